# cmake -D from=FOLDER -D to=FOLDER -P copy_pictures.cmake: copies the .png files.
file(GLOB pictures ${from}/*.png)
file(COPY ${pictures} DESTINATION ${to})
