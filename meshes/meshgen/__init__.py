"""meshgen: tetrahedral meshes of Durometer's bodies. JSON request in, MSH 4.1 and JSON manifest out."""
