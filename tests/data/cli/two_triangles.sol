MeshVersionFormatted 2
Dimension 2
SolAtVertices 4
1 3
100 0 400
100 0 400
100 0 100
400 0 100
End
