"""meshgen: tetrahedral meshes of Durometer's bodies. It reads a JSON request and writes an MSH 4.1 file and a JSON manifest."""
