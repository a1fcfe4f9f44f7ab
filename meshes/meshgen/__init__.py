"""meshgen: tetrahedral meshes of Durometer's bodies. It reads a request in JSON and writes MSH 4.1 and a manifest in JSON."""
