//! Mesh files: what is read, and one bad file per refusal in `tests/bad/`.

use crate::common::tools;
use durometer::math::tensor::Vec3;
use durometer::mesh::boundary::boundary_facets;
use durometer::mesh::format::recognise;
use durometer::mesh::validate::min_det;
use durometer::mesh::{self, Changes, MeshError, Order, Reading, TetMesh};
use durometer::scene::open_scene;
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
        assert_eq!(
            error,
            "the mesh has no region rot; did you mean `root`? (known: body, left part, middle, root, surface_6, tip)"
        );
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

fn cells_by_place(mesh: &TetMesh) -> Vec<Vec<[i64; 3]>> {
    let place = |&i: &u32| [0, 1, 2].map(|k| (mesh.points[i as usize][k] * 1e6).round() as i64);
    let mut cells: Vec<Vec<[i64; 3]>> =
        (0..mesh.cell_count()).map(|c| mesh.cell(c).iter().map(place).collect()).collect();
    cells.iter_mut().for_each(|c| c.sort_unstable());
    cells.sort();
    cells
}

/// The same mesh in gmsh's older format, where a cell of two groups is written twice, and in two partitions, whose parts of entities have the groups.
#[test]
fn msh_2_and_partitions_hold_the_same_mesh_and_groups() {
    let new = good("boxes.msh");
    for name in ["boxes-2.2.msh", "boxes-2.2-binary.msh", "boxes-partitioned.msh"] {
        let old = good(name);
        assert_eq!(cells_by_place(&old), cells_by_place(&new), "{name}");
        let names = |mesh: &TetMesh| mesh.regions.keys().cloned().collect::<Vec<_>>();
        assert_eq!(names(&old), names(&new), "{name}");
        for (region, list) in &new.regions {
            let same = &old.regions[region];
            assert!(
                (old.region_volume(&same.cells) - new.region_volume(&list.cells)).abs() < 1e-13,
                "{name}: {region}"
            );
            assert!((old.region_area(&same.facets) - new.region_area(&list.facets)).abs() < 1e-13, "{name}: {region}");
        }
    }
}

/// Two tetrahedra with groups of points, facets and cells that are all called `end`.
fn groups_of_one_name(more: &str) -> String {
    format!(
        "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n0 1 \"end\"\n2 1 \"end\"\n3 1 \"end\"\n$EndPhysicalNames\n{more}\
         $Entities\n1 0 1 2\n1 0 0 0 1 1\n1 0 0 0 1 1 1 1 1 0\n1 0 0 0 1 1 1 1 1 0\n2 0 0 0 1 1 1 0 0\n$EndEntities\n\
         $Nodes\n1 5 1 5\n3 1 0 5\n1\n2\n3\n4\n5\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 1 1\n$EndNodes\n\
         $Elements\n4 4 1 4\n0 1 15 1\n1 2\n2 1 2 1\n2 1 3 2\n3 1 4 1\n3 1 2 3 4\n3 2 4 1\n4 2 3 4 5\n$EndElements\n"
    )
}

/// Groups of one name are one region of a file of gmsh, but in other files a set of nodes and one of cells are two.
#[test]
fn a_node_set_holds_no_node_of_a_set_of_cells() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("end.msh");
    let of = |text: &str| {
        std::fs::write(&path, text).expect("writable");
        mesh::read(&path, 1.0).unwrap_or_else(|e| panic!("{e}"))
    };
    let nodes = |mesh: &TetMesh| mesh.nodes_of(&mesh.regions["end"]);
    let group = of(&groups_of_one_name(""));
    assert_eq!(nodes(&group), [0, 1, 2, 3]);
    let set = of(&groups_of_one_name("$MeshgenNodeSets\n1\n1 \"end\"\n$EndMeshgenNodeSets\n"));
    assert_eq!(nodes(&set), [1]);
    let end = &set.regions["end"];
    assert_eq!((end.facets.len(), &end.cells), (1, &vec![0]));
    assert_eq!((&end.facets, &end.cells), (&group.regions["end"].facets, &group.regions["end"].cells));
    assert!(set.facets_of(end).is_empty());
    // Without points of its own it is that of the facets
    let text = groups_of_one_name("$MeshgenNodeSets\n1\n1 \"end\"\n$EndMeshgenNodeSets\n");
    let held = of(&text.replace("1 0 0 0 1 1\n1 0", "1 0 0 0 0\n1 0"));
    assert_eq!((nodes(&held), held.facets_of(&held.regions["end"])), (vec![0, 1, 2], &held.regions["end"].facets[..]));
}

/// A node set whose nodes belong to no cell, such as a reference point, has none, also where cells have its name: what acts on nodes is refused.
#[test]
fn a_node_set_without_nodes_of_the_body_is_refused() {
    let text = groups_of_one_name("$MeshgenNodeSets\n1\n1 \"end\"\n$EndMeshgenNodeSets\n");
    let text = text.replace("1 0 0 0 1 1\n1 0", "1 0 0 0 0\n1 0").replacen("1 1 1 1 1 0\n", "1 1 1 0 0\n", 1);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("end.msh");
    std::fs::write(&path, text).expect("writable");
    let mesh = mesh::read(&path, 1.0).unwrap_or_else(|e| panic!("{e}"));
    let end = &mesh.regions["end"];
    assert_eq!((mesh.nodes_of(end), &end.cells), (vec![], &vec![0]));
    let scene = folder.path().join("scene.toml");
    for part in ["constraint]]\nkind = \"fixed\"", "probe]]\nkind = \"position\"", "probe]]\nkind = \"pose\""] {
        let text = format!(
            "[mesh]\nfile = \"end.msh\"\nunit = \"m\"\n[laws.rubber]\nlaw = \"neo_hookean\"\nE = \"100 kPa\"\nnu = 0.3\n[[effect]]\n\
             kind = \"elastic\"\nregion = \"body\"\nlaw = \"rubber\"\n[[constraint]]\nkind = \"fixed\"\nregion = \"body\"\ncomponents = \"x\"\n\
             [[{part}\nregion = \"end\"\n[[stage]]\nintegrator = \"static\"\nduration = \"1 s\"\ndt = \"1 s\"\n"
        );
        std::fs::write(&scene, text).expect("writable");
        let error = open_scene(&scene).map(|_| ()).expect_err(part).to_string();
        assert!(
            error.contains("the node set or surface \"end\" of the mesh file has no node of the body"),
            "{part}: {error}"
        );
    }
}

/// A binary legacy file of three tetrahedra in a row, with this data of the cells.
fn binary_vtk(data: &[&[u8]]) -> Vec<u8> {
    let mut out = b"# vtk DataFile Version 3.0\nx\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS 6 float\n".to_vec();
    let points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1], [2, 1, 1]];
    out.extend(points.iter().flatten().flat_map(|x| (*x as f32).to_be_bytes()));
    out.extend(b"\nCELLS 3 15\n");
    out.extend([4, 0, 1, 2, 3, 4, 1, 2, 3, 4, 4, 1, 2, 4, 5].iter().flat_map(|k: &i32| k.to_be_bytes()));
    out.extend(b"\nCELL_TYPES 3\n");
    out.extend([10i32; 3].iter().flat_map(|k| k.to_be_bytes()));
    out.extend(b"\nCELL_DATA 3\n");
    data.iter().for_each(|part| out.extend(*part));
    out
}

/// Regions with the number of their cells, and the notes of a file with these bytes.
fn regions_of(data: &[u8]) -> (Vec<(String, usize)>, Vec<String>) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("a.vtk");
    std::fs::write(&path, data).expect("writable");
    let (mesh, changes) = taken(&path, &reading(false, None)).unwrap_or_else(|e| panic!("{e}"));
    let regions = mesh.regions.iter().filter(|(name, _)| *name != "body");
    (regions.map(|(name, region)| (name.clone(), region.cells.len())).collect(), changes.notes)
}

/// VTK writes numbers of the type vtkIdType with four bytes, also where they have eight in memory.
#[test]
fn ids_of_binary_vtk_have_four_bytes() {
    let values = [7i32, 7, 9].map(i32::to_be_bytes).concat();
    let field = regions_of(&binary_vtk(&[b"FIELD FieldData 1\nRegionId 1 3 vtkIdType\n", &values, b"\n"]));
    assert_eq!(field, (vec![("RegionId_7".into(), 2), ("RegionId_9".into(), 1)], vec![]));
    let scalars = regions_of(&binary_vtk(&[b"SCALARS RegionId vtkIdType\nLOOKUP_TABLE default\n", &values, b"\n"]));
    assert_eq!(scalars, field);
}

/// Integers without a sign have the same values in a binary file as in a text, also those whose first bit is set.
#[test]
fn unsigned_integers_of_binary_vtk_have_no_sign() {
    for (kind, largest, bytes) in [
        ("unsigned_char", 255u64, 1),
        ("unsigned_short", 40_000, 2),
        ("unsigned_int", 4_000_000_000, 4),
        ("vtktypeuint32", 4_000_000_000, 4),
        ("vtktypeuint64", 5_000_000_000, 8),
    ] {
        let head = format!("SCALARS label {kind} 1\nLOOKUP_TABLE default\n");
        let values = [1, largest, 1].map(|v| v.to_be_bytes()[8 - bytes..].to_vec()).concat();
        let binary = regions_of(&binary_vtk(&[head.as_bytes(), &values, b"\n"]));
        assert_eq!(binary, regions_of(&text_vtk(&format!("{head}1 {largest} 1\n"))), "{kind}");
        assert_eq!(binary, (vec![("label_1".into(), 2), (format!("label_{largest}"), 1)], vec![]), "{kind}");
    }
    let signed = regions_of(&binary_vtk(&[b"SCALARS label char 1\nLOOKUP_TABLE default\n", &[1, 255, 1], b"\n"]));
    assert_eq!(signed.0, [("label_-1".to_string(), 1), ("label_1".to_string(), 2)]);
    let values = [1, u64::MAX, 1].map(u64::to_be_bytes).concat();
    let far = regions_of(&binary_vtk(&[b"SCALARS label vtktypeuint64 1\nLOOKUP_TABLE default\n", &values, b"\n"]));
    assert!(far.0.is_empty() && far.1.len() == 1, "{far:?}");
}

/// The data of the cells of a text of three tetrahedra in a row.
fn text_vtk(data: &str) -> Vec<u8> {
    let points = "0 0 0 1 0 0 0 1 0 0 0 1 1 1 1 2 1 1";
    format!(
        "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nFIELD FieldData 1\nTitle 1 1 string\nby%20me\nPOINTS 6 float\n{points}\n\
         CELLS 3 15\n4 0 1 2 3\n4 1 2 3 4\n4 1 2 4 5\nCELL_TYPES 3\n10 10 10\nCELL_DATA 3\n{data}"
    )
    .into_bytes()
}

/// Vectors, tensors, ids, colours and strings make no region, and those after them are read.
#[test]
fn data_of_vtk_that_make_no_region_are_passed_over() {
    let expected = (vec![("Part_7".to_string(), 2), ("Part_9".to_string(), 1)], Vec::<String>::new());
    let part = "SCALARS Part int 1\nLOOKUP_TABLE default\n7 7 9\n";
    let (nine, twenty) = (["1"; 9].join(" "), ["0.5"; 27].join(" "));
    for other in [
        format!("VECTORS v float\n{nine}\n"),
        format!("NORMALS n double\n{nine}\n"),
        format!("TENSORS t float\n{twenty}\n"),
        "GLOBAL_IDS g vtkIdType\n1 2 3\n".into(),
        "TEXTURE_COORDINATES t 2 float\n1 2 3 4 5 6\n".into(),
        "COLOR_SCALARS c 1\n0.1 0.2 0.3\n".into(),
        "LOOKUP_TABLE tab 2\n0 0 0 1 1 1 1 1\n".into(),
        "FIELD FieldData 2\nname 1 3 string\na\n\nb%20c\nflag 1 3 bit\n0 1 1\n".into(),
        "SCALARS x float 1\nLOOKUP_TABLE default\n1 2 3\nMETADATA\nINFORMATION 0\n\n".into(),
    ] {
        assert_eq!(regions_of(&text_vtk(&format!("{other}{part}POINT_DATA 6\n"))), expected, "{other}");
    }
    let values = [7i32, 7, 9].map(i32::to_be_bytes).concat();
    let long = [&[0x80, 70][..], &[b'x'; 70]].concat();
    let bytes = binary_vtk(&[
        b"FIELD FieldData 3\nname 1 3 string\n\xc1a\xc0",
        &long,
        b"\nflag 1 3 bit\n\x60\nPart 1 3 int\n",
        &values,
        b"\n",
    ]);
    assert_eq!(regions_of(&bytes), expected);
    let (regions, notes) = regions_of(&text_vtk(&format!("{part}STRANGE s float\n1 2 3\n")));
    assert_eq!(regions, expected.0);
    assert_eq!(notes, ["data of the cells from \"STRANGE\" on are not read, and make no regions"]);
}

/// What a conversion left out is told with every reading of the converted file.
#[test]
fn notes_of_a_conversion_are_kept_in_its_file() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("noted.msh");
    let notes = "$MeshgenNotes\n2\n1 \"springs are passed over\"\n2 \"and \"plates\" too\"\n$EndMeshgenNotes\n";
    std::fs::write(&path, groups_of_one_name(notes)).expect("writable");
    let (_, changes) = taken(&path, &reading(false, None)).expect("a good file");
    assert_eq!(changes.notes, ["springs are passed over", "and \"plates\" too"]);
}

fn reading(split: bool, merge: Option<f64>) -> Reading {
    Reading { unit_m: 1.0, split, merge }
}

fn taken(path: &Path, how: &Reading) -> Result<(TetMesh, Changes), MeshError> {
    mesh::read_as(path, path, recognise(path)?.reader, how)
}

#[test]
fn nodes_without_a_cell_are_dropped_and_counted() {
    let (mesh, changes) = taken(&file("good/orphan.msh"), &reading(false, None)).expect("a good file");
    assert_eq!((mesh.points.len(), mesh.cell_count()), (5, 2));
    assert_eq!(changes, Changes { dropped_nodes: 2, ..Changes::default() });
}

#[test]
fn doubled_nodes_are_merged_where_asked_for() {
    let path = file("duplicate.msh");
    let (mesh, changes) = taken(&path, &reading(false, Some(1e-9))).expect("merged");
    assert_eq!(changes, Changes { merged_nodes: 1, ..Changes::default() });
    assert_eq!(mesh.points.len(), 5);
    assert!((volume_of_surface(&mesh) - mesh.volume()).abs() < 1e-13);
    let error = taken(&path, &reading(false, Some(1.5))).expect_err("corners of a cell become one").to_string();
    assert!(error.contains("a corner of cell 1 twice; merge within a smaller distance"), "{error}");
}

/// A block of hexahedra, wedges, pyramids and tetrahedra with shuffled numbers: x < 1 hexahedra, 1 < x < 2 wedges, 2 < x < 3 six pyramids
/// each, one of which is cut in two tetrahedra.
fn mixed(seed: u64) -> String {
    let (ny, nz) = (3, 2);
    let mut points: Vec<[f64; 3]> = Vec::new();
    let mut number = std::collections::HashMap::new();
    let mut cells: Vec<(u8, Vec<usize>)> = Vec::new();
    let mut node = |p: [f64; 3]| {
        *number.entry(p.map(|x| (2.0 * x) as i64)).or_insert_with(|| {
            points.push(p);
            points.len() - 1
        })
    };
    for (i, j, k) in (0..3).flat_map(|i| (0..ny).flat_map(move |j| (0..nz).map(move |k| (i, j, k)))) {
        let [x, y, z] = [i, j, k].map(f64::from);
        let h: Vec<usize> = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
            .map(|d| node([x + f64::from(d[0]), y + f64::from(d[1]), z + f64::from(d[2])]))
            .to_vec();
        match i {
            0 => cells.push((12, h)),
            1 => {
                cells.push((13, [0, 1, 2, 4, 5, 6].map(|n| h[n]).to_vec()));
                cells.push((13, [0, 2, 3, 4, 6, 7].map(|n| h[n]).to_vec()));
            }
            _ => {
                let apex = node([x + 0.5, y + 0.5, z + 0.5]);
                let sides = [[0, 1, 2, 3], [4, 7, 6, 5], [0, 4, 5, 1], [1, 5, 6, 2], [2, 6, 7, 3], [3, 7, 4, 0]];
                cells.extend(sides.map(|s| (14, s.map(|n| h[n]).into_iter().chain([apex]).collect::<Vec<_>>())));
            }
        }
    }
    // Another order of the nodes
    let mut order: Vec<usize> = (0..points.len()).collect();
    let mut state = seed;
    for i in (1..order.len()).rev() {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        order.swap(i, (state >> 33) as usize % (i + 1));
    }
    let place: Vec<usize> =
        (0..order.len()).map(|n| order.iter().position(|&o| o == n).expect("a permutation")).collect();
    let lines: Vec<String> = order.iter().map(|&n| points[n].map(|x| x.to_string()).join(" ")).collect();
    let size: usize = cells.iter().map(|c| c.1.len() + 1).sum();
    let rows: Vec<String> = (cells.iter())
        .map(|(_, nodes)| {
            format!("{} {}", nodes.len(), nodes.iter().map(|&n| place[n].to_string()).collect::<Vec<_>>().join(" "))
        })
        .collect();
    let kinds: Vec<String> = cells.iter().map(|c| c.0.to_string()).collect();
    let sides: Vec<&str> = cells.iter().map(|c| if c.0 == 12 { "1" } else { "2" }).collect();
    format!(
        "# vtk DataFile Version 2.0\nmixed\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {} double\n{}\nCELLS {} {size}\n{}\nCELL_TYPES {}\n{}\n\
         CELL_DATA {}\nSCALARS side int 1\nLOOKUP_TABLE default\n{}\n",
        lines.len(),
        lines.join("\n"),
        cells.len(),
        rows.join("\n"),
        cells.len(),
        kinds.join("\n"),
        cells.len(),
        sides.join("\n"),
    )
}

/// Cells that share a quadrilateral cut it alike: the surface of the divided mesh is that of the block and no more, whatever the numbers.
#[test]
fn mixed_cells_are_split_without_gaps() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("mixed.vtk");
    for seed in 0..20 {
        std::fs::write(&path, mixed(seed)).expect("writable");
        assert!(matches!(taken(&path, &reading(false, None)), Err(MeshError::NotSplit { .. })));
        let (mesh, changes) = taken(&path, &reading(true, None)).unwrap_or_else(|e| panic!("{e}"));
        let boxes = 6;
        assert_eq!(changes.split_cells, boxes * (1 + 2 + 6));
        assert_eq!(mesh.cell_count(), boxes * (6 + 2 * 3 + 6 * 2));
        assert!((mesh.volume() - 18.0).abs() < 1e-12, "seed {seed}: {}", mesh.volume());
        assert!((volume_of_surface(&mesh) - 18.0).abs() < 1e-12, "seed {seed}");
        let surface = mesh.region_area(&boundary_facets(&mesh));
        assert!((surface - 2.0 * (9.0 + 6.0 + 6.0)).abs() < 1e-12, "seed {seed}: a gap has a surface: {surface}");
        assert!((mesh.region_volume(&mesh.regions["side_1"].cells) - 6.0).abs() < 1e-12, "regions are divided too");
    }
}

/// Regions come from the data of the cells, which are last in a file: one that ends within them is refused, text and binary.
#[test]
fn data_of_cells_that_are_cut_off_are_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("cut.vtk");
    for (name, last) in
        [("good/boxes-5.1.vtk", "vtktypeint32\n"), ("good/boxes-order2-binary.vtk", "LOOKUP_TABLE default\n")]
    {
        let data = std::fs::read(file(name)).expect("there");
        let find = |text: &str| {
            data.windows(text.len()).rposition(|w| w == text.as_bytes()).expect("in the file") + text.len()
        };
        let (begin, values) = (find("CELL_DATA 60\n"), find(last));
        // Words of two letters with the blank behind, or integers of four bytes
        let end = values + if name.contains("binary") { 60 * 4 } else { 60 * 2 - 1 };
        for cut in begin + 1..end {
            std::fs::write(&path, &data[..cut]).expect("writable");
            let error = mesh::read(&path, 1.0).expect_err("cut off").to_string();
            assert!(error.contains("the file ends where ") && error.ends_with(CUT), "{name}, {cut} bytes: {error}");
        }
        std::fs::write(&path, &data[..end]).expect("writable");
        assert_eq!(cells_by_place(&mesh::read(&path, 1.0).expect("whole")), cells_by_place(&good(&name[5..])));
    }
    // Data that the reader does not know make no region
    let text = std::fs::read_to_string(file("good/boxes-5.1.vtk")).expect("there");
    std::fs::write(&path, text.replace("FIELD FieldData 1\nCell", "SPINORS flow double\nCell")).expect("writable");
    let mesh = mesh::read(&path, 1.0).expect("a mesh");
    assert!(mesh.regions.keys().all(|name| !name.starts_with("Cell")), "{:?}", mesh.regions.keys());
}

/// Words by which C on Windows writes them, in the middle and at the end of the data of the cells, cost no region.
#[test]
fn numbers_that_are_not_finite_are_numbers() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("quality.vtk");
    let head = std::fs::read_to_string(file("nan-type.vtk")).expect("there").replace("\nnan", "\n10\nCELL_DATA 2");
    let side = "SCALARS side int 1\nLOOKUP_TABLE default\n1 2\n";
    for word in ["nan", "-nan(ind)", "nan(snan)", "1.#QNAN", "-1.#IND00", "1.#INF"] {
        let quality = format!("SCALARS quality double 1\nLOOKUP_TABLE default\n1.0 {word}\n");
        for data in [format!("{quality}{side}"), format!("{side}{quality}")] {
            std::fs::write(&path, format!("{head}{data}")).expect("writable");
            let mesh = mesh::read(&path, 1.0).unwrap_or_else(|e| panic!("{word}: {e}"));
            assert!(["side_1", "side_2"].iter().all(|name| mesh.regions.contains_key(*name)), "{word}");
        }
    }
}

/// Voxels are hexahedra with their nodes in another order.
#[test]
fn voxels_are_split_as_hexahedra() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("voxels.vtk");
    let [voxels, hexahedra] =
        [(11, [0, 1, 2, 3, 4, 5, 6, 7]), (12, [0, 1, 3, 2, 4, 5, 7, 6])].map(|(kind, order): (usize, [usize; 8])| {
            let row = |first: usize| order.map(|n| (first + n).to_string()).join(" ");
            let points = (0..12).map(|i| format!("{} {} {}\n", i % 2, i / 2 % 2, i / 4)).collect::<String>();
            let head = "# vtk DataFile Version 3.0\nvoxels\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 12 double\n";
            let text = format!("{head}{points}CELLS 2 18\n8 {}\n8 {}\nCELL_TYPES 2\n{kind} {kind}\n", row(0), row(4));
            std::fs::write(&path, text).expect("writable");
            let error = taken(&path, &reading(false, None)).expect_err("not split").to_string();
            assert!(error.ends_with(&format!(": 2 × 8-node hexahedra; {SPLIT}")), "{error}");
            taken(&path, &reading(true, None)).unwrap_or_else(|e| panic!("{e}")).0
        });
    assert!(voxels.cell_count() == 12 && (voxels.volume() - 2.0).abs() < 1e-14, "{}", voxels.volume());
    assert_eq!(voxels, hexahedra);
}

/// The same bytes under any name, and marks that decide.
#[test]
fn the_content_decides_about_the_format() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("body.stl");
    let data = std::fs::read(file("good/boxes-5.1.vtk")).expect("there");
    let marked: Vec<u8> = b"\xef\xbb\xbf".iter().chain(&data).copied().collect();
    let windows = String::from_utf8_lossy(&data).replace('\n', "\r\n").into_bytes();
    for bytes in [&data, &marked, &windows] {
        std::fs::write(&path, bytes).expect("writable");
        let mesh = mesh::read(&path, 1.0).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(cells_by_place(&mesh), cells_by_place(&good("boxes-5.1.vtk")));
    }
    for (name, text, is) in [
        ("a.vtk", "<?xml version=\"1.0\"?>\n<!-- made by hand -->\n<VTKFile type=\"UnstructuredGrid\">", "XML VTK"),
        ("a.txt", "** a comment\n*Heading\n", "Abaqus input"),
        ("b.inp", "** a comment\n*Material, name=rubber\n*Hyperelastic\n", "Abaqus input"),
        ("a.msh", "$MeshFormat\n4.0 0 8\n", "MSH, an old version"),
        ("a.vtk", "MeshVersionFormatted 2\n", "Medit"),
        ("a.dat", "ISO-10303-21;\nHEADER;", "STEP"),
        ("a.unv", "    -1\n  2411\n", "I-DEAS universal"),
        ("a.stl", "anything", "STL"),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("writable");
        assert_eq!(recognise(&path).map(|f| f.name), Ok(is), "{name}");
    }
    for (name, text, says) in [
        ("a.inp", "finger 3", "the content is not that of a file of Abaqus input; check the path, or write it again"),
        ("a.vtk", "", "the file is empty"),
        ("a.xyz", "hello", "neither the content nor the name is that of a known format"),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("writable");
        let error = recognise(&path).expect_err(name).to_string();
        assert!(error.contains(says), "{error}");
    }
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
const MID_NODES: &str = "write those of the corners 1 to 4 in the order 12 23 13 14 34 24 in MSH, 12 23 13 14 24 34 in VTK and Abaqus files";
const SPLIT: &str = "add split = true to [mesh]: hexahedra, wedges and pyramids become tetrahedra with the same nodes";

#[test]
fn every_bad_file_is_refused_with_its_message() {
    let known = [
        ("duplicate.msh", ": nodes 2 and 6 are both at (1000, 0, 0) mm: a duplicate node is a crack; merge them: merge = \"1e-6 mm\" in [mesh]".to_string()),
        ("folded.msh", ": curved cell 1 folds over: its det J reaches -2.000e-1 m^3; use a smaller size there, or order 1".into()),
        ("hexahedron.vtk", format!(": 1 × 8-node hexahedra; {SPLIT}")),
        ("huge-count.msh", format!(", line 6: the file ends where the nodes of a block (500000000000 announced) should follow; {CUT}")),
        ("inverted.msh", ": cell 2 is inverted (volume -3.333e-1 m^3; 1 of 3 cells); renumber its nodes or remesh".into()),
        ("loose-facet.msh", ": facet 2 of region root is no face of any cell; save the volume next to it".into()),
        ("mesh.inp", ": this file type is not read directly; give it as [mesh] file in a scene: other formats go through the mesher".into()),
        ("mid-node-order.msh", format!(": node 9 of cell 1 is the mid-node of the edge 2-4 and lies at the edge 3-4, and so in 1 of 1 cells: the mid-nodes are in the order of another program; {MID_NODES}")),
        ("mid-node-twice.msh", format!(": cells 1 and 2 have a face in common, and the mid-node of its edge 2-3 is 7 in one and 15 in the other: the face is a crack, or the mid-nodes are in the order of another program; merge the two nodes (merge in [mesh]), or {MID_NODES}")),
        ("mixed-order.msh", format!(": mixed-cell mesh: 1 × 10-node tetrahedra, 2 × 4-node tetrahedra; {ONLY}")),
        ("mixed.msh", format!(": 2 × 4-node tetrahedra, 1 × 5-node pyramids; {SPLIT}")),
        ("negative-node.msh", ": element 2 refers to node -3, which the file does not define; write the file again".into()),
        ("negative-node.vtk", ": cell 1 refers to node -3, which the file does not define; write the file again".into()),
        ("negative-node-2.msh", ": element 2 refers to node -3, which the file does not define; write the file again".into()),
        ("no-format.msh", format!(", line 1: expected $MeshFormat, found \"$Nodes\"; {DAMAGED}")),
        ("node-twice.msh", ": node 4 is defined twice; write the file again".into()),
        ("not-a-number.msh", format!(", line 14: expected a coordinate, found \"l\"; {DAMAGED}")),
        ("not-finite.msh", format!(": node 5 has a coordinate that is not finite; {DAMAGED}")),
        ("overlap.msh", ": cells 1 and 3 are on the same side of a face that both have, so that they overlap; remove one of them".into()),
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
        ("unknown-type.msh", ": element type 99 is not known; save tetrahedra of order 1 or 2, or hexahedra, wedges or pyramids of order 1, which split = true of [mesh] divides".into()),
        ("truncated-2.msh", format!(", line 5: the file ends where the nodes (5 announced) should follow; {CUT}")),
        ("unknown-node-2.msh", ": element 2 refers to node 5, which the file does not define; write the file again".into()),
        ("lost-node-2.msh", format!(", line 31: expected an element on a line of its own, found \"7 4 2 2 2 5 9 11\"; {DAMAGED}")),
        ("count-twice-2.msh", format!(", line 25: expected an element on a line of its own, found \"18\"; {DAMAGED}")),
        ("decimal-node.vtk", format!(", line 9: expected the nodes of the cells, found \"4.9\"; {DAMAGED}")),
        ("nan-type.vtk", format!(", line 12: expected the cell types, found \"nan\"; {DAMAGED}")),
        ("utf-16.vtk", ": this is text in UTF-16; save it as UTF-8".into()),
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
    for name in [
        "boxes.msh",
        "boxes-2.2.msh",
        "boxes-2.2-binary.msh",
        "boxes-binary.msh",
        "boxes-order2-binary.vtk",
        "boxes-5.1.vtk",
    ] {
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
