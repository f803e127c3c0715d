# cmake -D from=FOLDER -D to=FOLDER -P copy_pictures.cmake: copies the .png files of the gallery.
file(GLOB pictures ${from}/*.png)
# Its colours make it large, and it shows the mesh of figure 15 again.
list(FILTER pictures EXCLUDE REGEX quality)
file(COPY ${pictures} DESTINATION ${to})
