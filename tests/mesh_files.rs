//! Mesh files: what is read, and one bad file per refusal in `tests/bad/`.

mod tools;

use durometer::math::tensor::Vec3;
use durometer::mesh::boundary::boundary_facets;
use durometer::mesh::validate::min_det;
use durometer::mesh::{self, MeshError, Order, TetMesh};
use std::io::Write;
use std::path::{Path, PathBuf};

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/bad").join(name)
}

fn good(name: &str) -> TetMesh {
    mesh::read(&file("good").join(name), 1.0).unwrap_or_else(|e| panic!("{e}"))
}

/// ∮ x·n dA / 3: the volume, if the facets are the whole boundary and outward.
fn volume_of_surface(mesh: &TetMesh) -> f64 {
    let rule = mesh::quadrature::tri(4);
    let flux = |f: u32| {
        let term = |(xi, w): (&[f64; 2], &f64)| {
            let n = mesh::element::facet_shape(mesh.order, *xi);
            let x: Vec3 = mesh.facet(f as usize).iter().zip(n).map(|(&i, n)| mesh.points[i as usize] * n).sum();
            w * x.dot(&mesh.facet_normal(f as usize, *xi))
        };
        rule.points.iter().zip(&rule.weights).map(term).sum::<f64>()
    };
    boundary_facets(mesh).into_iter().map(flux).sum::<f64>() / 3.0
}

/// Two unit cubes side by side along x, as gmsh 4.15 writes them, in every format.
#[test]
fn gmsh_files_of_every_format_give_the_same_mesh() {
    let text = good("boxes.msh");
    assert_eq!(text, good("boxes-binary.msh"));
    for name in ["boxes.msh", "boxes-order2-binary.msh", "boxes-order2-binary.vtk", "boxes-5.1.vtk"] {
        let mesh = good(name);
        assert_eq!(mesh.cell_count(), 48, "{name}");
        assert!((mesh.volume() - 2.0).abs() < 1e-13, "{name}");
        assert!((volume_of_surface(&mesh) - 2.0).abs() < 1e-13, "{name}");
        assert_eq!(mesh.bounding_box(), (Vec3::zeros(), Vec3::new(2.0, 1.0, 1.0)), "{name}");
        assert_eq!(mesh.regions["body"].cells.len(), 48, "{name}");
    }
}

#[test]
fn physical_groups_become_regions() {
    for name in ["boxes.msh", "boxes-order2-binary.msh"] {
        let mesh = good(name);
        let names: Vec<&str> = mesh.regions.keys().map(String::as_str).collect();
        // The face x = 2 is in a named and in an unnamed group; the left cube is in two groups.
        assert_eq!(names, ["body", "left part", "middle", "root", "surface_6", "tip"]);
        assert!((mesh.region_volume(&mesh.regions["left part"].cells) - 1.0).abs() < 1e-13);
        assert_eq!(mesh.regions["tip"], mesh.regions["surface_6"]);
        for (region, x) in [("root", 0.0), ("middle", 1.0), ("tip", 2.0)] {
            let region = &mesh.regions[region];
            assert!((mesh.region_area(&region.facets) - 1.0).abs() < 1e-13);
            assert!(mesh.nodes_of(region).iter().all(|&i| (mesh.points[i as usize].x - x).abs() < 1e-12));
        }
        // The face between the cubes is a region, but no boundary.
        let boundary = boundary_facets(&mesh);
        assert!(mesh.regions["middle"].facets.iter().all(|f| !boundary.contains(f)));
        assert_eq!(boundary.len() + mesh.regions["middle"].facets.len(), mesh.facet_count());
        let error = mesh.region("rot").expect_err("not there").to_string();
        assert_eq!(error, "the mesh has no region rot; did you mean root?");
    }
}

/// The mid-nodes of gmsh's second-order tetrahedra are on the middle of the edges that VTK's order says.
#[test]
fn mid_nodes_are_in_vtk_order() {
    for name in ["boxes-order2-binary.msh", "boxes-order2-binary.vtk"] {
        let mesh = good(name);
        assert_eq!(mesh.order, Order::Quadratic);
        for c in 0..mesh.cell_count() {
            let x: Vec<Vec3> = mesh.cell(c).iter().map(|&i| mesh.points[i as usize]).collect();
            for (e, [a, b]) in mesh::element::CELL_EDGES.into_iter().enumerate() {
                assert!((x[4 + e] - (x[a] + x[b]) / 2.0).norm() < 1e-12, "{name}: cell {c}, edge {e}");
            }
            assert!(min_det(&mesh, c) > 0.0);
        }
    }
}

#[test]
fn gzip_units_and_a_reversed_orientation() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("boxes.msh.gz");
    let text = std::fs::read(file("good/boxes.msh")).expect("there");
    let mut gz = flate2::write::GzEncoder::new(std::fs::File::create(&path).expect("writable"), Default::default());
    gz.write_all(&text).and_then(|()| gz.finish().map(drop)).expect("writable");
    let mesh = mesh::read(&path, 1e-3).expect("a good file");
    assert!((mesh.volume() / 2e-9 - 1.0).abs() < 1e-13);

    // Mirrored: every cell of the file has negative volume.
    let mirrored = folder.path().join("mirrored.vtk");
    let text = std::fs::read_to_string(file("good/boxes-5.1.vtk")).expect("there");
    let (head, rest) = text.split_once("double\n").expect("points");
    let (points, rest) = rest.split_once("\nCELLS").expect("cells");
    let negative: Vec<String> = points.split_whitespace().map(|x| format!("-{x}")).collect();
    std::fs::write(&mirrored, format!("{head}double\n{}\nCELLS{rest}", negative.join(" "))).expect("writable");
    let mesh = mesh::read(&mirrored, 1.0).expect("a good file");
    assert!((mesh.volume() - 2.0).abs() < 1e-13 && (volume_of_surface(&mesh) - 2.0).abs() < 1e-13);
}

/// The finger of an older SOFA scene, in millimetres.
#[test]
#[ignore = "reads public data outside of the project, from the folder that DUROMETER_SHARED names"]
fn the_shared_finger_reads() {
    let path = tools::shared("data/finger/finger.vtk");
    let mesh = mesh::read(&path, 1e-3).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!((mesh.points.len(), mesh.order), (158, Order::Linear));
    assert!((volume_of_surface(&mesh) / mesh.volume() - 1.0).abs() < 1e-12);
}

const DAMAGED: &str = "the file is damaged, write it again";
const CUT: &str = "it is truncated, write or copy it again";
const ONLY: &str = "only tetrahedra of one order are read: remesh the body with tetrahedra";

#[test]
fn every_bad_file_is_refused_with_its_message() {
    let known = [
        ("duplicate.msh", ": nodes 2 and 6 are both at (1000, 0, 0) mm: a duplicate node is a crack; merge them (gmsh: Coherence Mesh)".to_string()),
        ("folded.msh", ": curved cell 1 folds over: its det J reaches -2.000e-1 m^3; use a smaller size there, or order 1".into()),
        ("hexahedron.vtk", format!(": mixed-cell mesh: 1 × 8-node hexahedra; {ONLY}")),
        ("huge-count.msh", format!(", line 6: the file ends where the nodes of a block (500000000000 announced) should follow; {CUT}")),
        ("inverted.msh", ": cell 2 is inverted (volume -3.333e-1 m^3; 1 of 3 cells); renumber its nodes or remesh".into()),
        ("loose-facet.msh", ": facet 2 of region root is no face of any cell; save the volume next to it".into()),
        ("mesh.inp", ": this file type is not read directly; in a scene give it as [mesh] file with a size: STEP, BREP, STL, OBJ and what meshio reads go through the mesher".into()),
        ("mixed-order.msh", format!(": mixed-cell mesh: 1 × 10-node tetrahedra, 2 × 4-node tetrahedra; {ONLY}")),
        ("mixed.msh", format!(": mixed-cell mesh: 2 × 4-node tetrahedra, 1 × 5-node pyramids; {ONLY}")),
        ("no-format.msh", format!(", line 1: expected $MeshFormat, found \"$Nodes\"; {DAMAGED}")),
        ("node-twice.msh", ": node 4 is defined twice; write the file again".into()),
        ("not-a-number.msh", format!(", line 14: expected a coordinate, found \"l\"; {DAMAGED}")),
        ("not-finite.msh", format!(": node 5 has a coordinate that is not finite; {DAMAGED}")),
        ("orphan.msh", ": orphan node 6 at (7000, 0, 0) mm belongs to no cell (2 such nodes); delete it, its motion is undefined".into()),
        ("partial-body.msh", ": region \"body\" holds 1 of 2 cells; the name is kept for the whole body, rename the group".into()),
        ("shared-face.msh", ": a face of cell 3 is shared by three or more cells; remove the duplicated cells".into()),
        ("structured.vtk", ": a dataset of type STRUCTURED_POINTS holds no tetrahedra; write the mesh as UNSTRUCTURED_GRID".into()),
        ("surface-only.msh", ": no tetrahedra (only 1 × lines, 2 × triangles); mesh the volume, or save its elements too (gmsh: Mesh.SaveAll = 1 or a physical volume)".into()),
        ("truncated-binary.msh", format!(", byte 3511: the file ends where a coordinate should follow; {CUT}")),
        ("truncated-elements.msh", format!(", line 20: the file ends where the elements of a block (2 announced) should follow; {CUT}")),
        ("truncated-nodes.msh", format!(", line 6: the file ends where the nodes of a block (5 announced) should follow; {CUT}")),
        ("truncated.vtk", format!(", line 9: the file ends where the nodes of the cells should follow; {CUT}")),
        ("type-count.vtk", ": 2 cells but 1 cell types; write the file again".into()),
        ("unknown-node.msh", ": element 2 refers to node 9, which the file does not define; write the file again".into()),
        ("unknown-node.vtk", ": cell 1 refers to node 8, which the file does not define; write the file again".into()),
        ("unknown-type.msh", ": element type 99 is not known; save tetrahedra of order 1 or 2 only".into()),
        ("version-2.msh", ": MSH version 2.2 is not read; write it with gmsh -format msh41".into()),
        ("zero-volume.msh", ": cell 2 has zero volume (0.000e0 m^3); remove or remesh it".into()),
    ];
    for (name, message) in &known {
        let path = file(name);
        let error = mesh::read(&path, 1.0).expect_err(name);
        assert_eq!(error.to_string(), format!("{}{message}", path.display()), "{name}");
    }
    // A file that is added must be listed here.
    let files = std::fs::read_dir(file("")).expect("the folder").flatten().filter(|e| e.path().is_file());
    let meshes = files.filter(|e| e.path().extension().is_some_and(|x| ["msh", "vtk", "inp"].iter().any(|k| x == *k)));
    assert_eq!(meshes.count(), known.len());
    assert!(matches!(mesh::read(&file("absent.msh"), 1.0), Err(MeshError::Unreadable { .. })));
}

/// No prefix of a good file, and no file with a byte changed, may panic.
#[test]
fn damaged_files_do_not_panic() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for name in ["boxes.msh", "boxes-binary.msh", "boxes-order2-binary.vtk", "boxes-5.1.vtk"] {
        let data = std::fs::read(file("good").join(name)).expect("there");
        let path = folder.path().join(name);
        for k in (0..data.len()).step_by(97) {
            std::fs::write(&path, &data[..k]).expect("writable");
            // VTK files may lose their cell data, which only names regions.
            let cut = mesh::read(&path, 1.0);
            assert!(cut.is_err() || name.ends_with("vtk"), "{name}, first {k} bytes");
            let mut changed = data.clone();
            changed[k] = changed[k].wrapping_add(101);
            std::fs::write(&path, &changed).expect("writable");
            let _ = mesh::read(&path, 1.0);
        }
    }
}
