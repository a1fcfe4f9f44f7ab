//! Tests of the mesher's driver with shell scripts in place of the mesher.

use super::*;
use crate::mesh::MeshError;
use crate::mesh::file::vtu;
use crate::mesh::made::structured;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

const BODY: &str = r#"
version = 3
summary = "a rod"
[parameters]
length = { default = "100 mm", meaning = "root to tip" }
width = { default = "20 mm", meaning = "of the section" }
phalanges = { default = "4", meaning = "their number" }
[regions]
body = { dim = 3, meaning = "all" }
[features]
notches = { meaning = "distance from the notches" }
"#;

/// One tetrahedron, and the manifest the mesher would write for it.
const MESH: &str = "$MeshFormat\\n4.1 0 8\\n$EndMeshFormat\\n$Nodes\\n1 4 1 4\\n3 1 0 4\\n1\\n2\\n3\\n4\\n0 0 0\\n1 0 0\\n0 1 0\\n0 0 1\\n\
$EndNodes\\n$Elements\\n1 1 1 1\\n3 1 4 1\\n1 1 2 3 4\\n$EndElements\\n";
const MANIFEST: &str = r#"{"request":{"body":"rod","output":"x"},"cells":1,"nodes":4,"facets":4,"order":1,"h_m":0.55,
"regions":{"body":{"dim":3,"count":1}},"quality":{"sicn_min":0.5},"volume_m3":0.1667,"volume_cad_m3":null,"volume_error":null,
"edge_error_m":0.0,"paths":{"cable":{"guides":[[0.1,0,0]],"pull_point":[-1,0,0],"guide_radius":0.004}},
"versions":{"gmsh":"4.15.2","cgal":null},"wall_s":0.1,"length_m":0.0039}"#;

/// A project with the body `rod` whose Python is a shell script.
fn project(script: &str) -> (tempfile::TempDir, MeshStore) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let home = folder.path().to_path_buf();
    for sub in ["meshes/meshgen", "meshes/rod"] {
        std::fs::create_dir_all(home.join(sub)).expect("writable");
    }
    std::fs::write(home.join("meshes/rod/body.toml"), BODY).expect("writable");
    let python = home.join("python");
    // Written under another name first: a file that is open for writing cannot be run.
    std::fs::write(home.join("script"), format!("#!/bin/sh\n{script}\n")).expect("writable");
    std::fs::set_permissions(home.join("script"), PermissionsExt::from_mode(0o755)).expect("ours");
    std::fs::rename(home.join("script"), &python).expect("writable");
    (folder, MeshStore::of_project(home, python))
}

fn working() -> String {
    let out = r#"out=$(sed 's/.*"output":"\([^"]*\)".*/\1/')"#;
    format!("{out}\necho sizing >&2; echo meshing >&2\nprintf '{MESH}' | gzip > \"$out\"\ncat <<'END'\n{MANIFEST}\nEND")
}

fn request() -> MeshRequest {
    MeshRequest::body("rod", Size::Length(0.004))
}

fn message(result: Result<Generated, GenerateError>) -> String {
    result.expect_err("must be refused").to_string()
}

#[test]
fn a_mesh_is_made_once_and_found_from_then_on() {
    let (_folder, store) = project(&working());
    assert_eq!(store.stored(&request()), Ok(None));
    let mut lines = Vec::new();
    let first = store.mesh(&request(), &mut |l| lines.push(l.to_string())).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(lines, ["sizing", "meshing"]);
    assert!(first.made && first.mesh.cell_count() == 1 && first.path.starts_with(store.home.path.join("meshes/cache")));
    assert_eq!(first.manifest.paths["cable"].guide_radius, 0.004);
    assert_eq!(first.manifest.notes["length_m"], 0.0039);
    assert!(first.manifest.request.get("output").is_none(), "a manifest must not carry the path of a cache");
    let broken = MeshStore { python: "no-such-python".into(), ..store.clone() };
    let second = broken.mesh(&request(), &mut |_| panic!("no mesher is needed")).expect("stored");
    assert!(!second.made && second.mesh == first.mesh && second.name == first.name);
    let committed = broken.commit(&request(), &mut |_| {}).expect("stored");
    assert_eq!(committed, store.home.path.join("meshes/rod").join(format!("{}.msh.gz", first.name)));
    assert_eq!(broken.stored(&request()), Ok(Some(committed)));
    let left: Vec<_> = std::fs::read_dir(store.home.path.join("meshes/cache")).expect("there").collect();
    assert!(left.is_empty(), "{left:?}");
}

/// A mesh is made again when the Python code of its body changes, or that of a body which it uses, and when its manifest does not say what it was
/// made from.
#[test]
fn a_mesh_is_made_anew_when_the_geometry_of_its_body_changes() {
    let (_folder, store) = project(&working());
    let meshes = store.home.path.join("meshes");
    std::fs::create_dir_all(meshes.join("stub")).expect("writable");
    std::fs::write(meshes.join("stub/body.toml"), BODY).expect("writable");
    let write = |file: &str, text: &str| std::fs::write(meshes.join(file), text).expect("writable");
    let made = || store.mesh(&request(), &mut |_| {}).unwrap_or_else(|e| panic!("{e}")).made;
    assert!(made() && !made());
    write("rod/geometry.py", "from stub.geometry import build\n");
    write("stub/geometry.py", "SIZE = 1\n");
    assert!(made() && !made(), "of an earlier version, or committed without Python");
    for (file, text) in
        [("rod/geometry.py", "from stub.geometry import build\nSIZE = 2\n"), ("stub/geometry.py", "SIZE = 2\n")]
    {
        write(file, text);
        assert_eq!(store.stored(&request()), Ok(None), "{file}");
        assert!(made() && !made(), "{file}");
    }
    // A mesh that is stored with its body is also set aside, and is found again with the geometry that it was made from
    let committed = store.commit(&request(), &mut |_| {}).expect("stored");
    write("stub/geometry.py", "SIZE = 3\n");
    assert!(made());
    write("stub/geometry.py", "SIZE = 2\n");
    assert_eq!(store.stored(&request()), Ok(Some(committed)));
}

/// Files of a user next to the meshes of a body, and manifests without a mesh, do not count as meshes.
#[test]
fn only_meshes_have_a_stored_size() {
    let (_folder, store) = project(&working().replace(r#""body":"rod""#, r#""body":"rod","size":{"cells":300}"#));
    let asked = |count| MeshRequest::body("rod", Size::Cells { count, tolerance: 0.02 });
    store.mesh(&asked(300), &mut |_| {}).unwrap_or_else(|e| panic!("{e}"));
    for name in ["rod/notes.json", "rod/0123456789abcdef.json", "cache/fedcba9876543210.json", "cache/plan.json"] {
        std::fs::write(store.home.path.join("meshes").join(name), "{}").expect("writable");
    }
    assert_eq!(store.stored_sizes(&asked(600)), Ok(vec![300]));
}

#[test]
fn the_name_depends_on_what_is_meshed_and_on_nothing_else() {
    let (_folder, store) = project("");
    let name = |r: &MeshRequest| r.resolve(&store.home.path).expect("a good request").1;
    let base = name(&request());
    assert_eq!(base, "c30d5282303bca8e", "committed meshes are found by this name: it must not change");
    let with = |parameter: &str, value: f64| {
        let parameters = [(parameter.to_string(), value)].into();
        name(&MeshRequest { source: Source::Body { name: "rod".into(), parameters }, ..request() })
    };
    assert_eq!(with("width", 0.02), base, "a default that is spelled out");
    assert_ne!(with("width", 0.021), base);
    assert_ne!(name(&MeshRequest { seed: 1, ..request() }), base);
    assert_ne!(name(&MeshRequest::body("rod", Size::Cells { count: 4500, tolerance: 0.02 })), base);
    // In earlier versions, cells of several solids meshed by CGAL belonged to none of them
    let by_cgal = name(&MeshRequest { generator: Generator::Cgal, ..request() });
    assert_ne!(by_cgal, "6d7fab3e9b2cb891", "the name of a mesh of the mesher before");
    // Cells near the faces of a feature used to be graded in patches; meshes graded elsewhere are unchanged
    let graded = |near| {
        let grading = vec![Grading { near, length: 0.001, distance: 0.002 }];
        MeshRequest { grading, ..request() }.version()
    };
    let places = [GradedPlace::Feature("notches".into()), GradedPlace::Points(vec![[0.0; 3]])];
    assert_eq!((request().version(), places.map(graded)), (0, [1, 0]));
    // A file is identified by its content.
    let (a, b) = (store.home.path.join("a.stl"), store.home.path.join("b.stl"));
    [&a, &b].iter().for_each(|p| std::fs::write(p, "solid").expect("writable"));
    let file = |p: &Path| name(&MeshRequest { source: Source::File { path: p.into(), unit_m: 1e-3 }, ..request() });
    let before = file(&a);
    assert_eq!(before, file(&b));
    std::fs::write(&b, "solid other").expect("writable");
    assert_ne!(before, file(&b));
}

/// A mesh file that includes another, in the folder of a project.
fn with_included(store: &MeshStore) -> (std::path::PathBuf, impl Fn(&str)) {
    let (file, other) = (store.home.path.join("m.inp"), store.home.path.join("nodes.inp"));
    std::fs::write(&file, "*HEADING\n*Include, input=nodes.inp\n").expect("writable");
    let write = move |text: &str| std::fs::write(&other, text).expect("writable");
    write("*NODE\n1, 0, 0, 0\n");
    (file, write)
}

#[test]
fn a_mesh_file_is_converted_anew_when_a_file_that_it_includes_changes() {
    let (_folder, store) = project(&working());
    let (file, write) = with_included(&store);
    let convert = || store.converted(&file, "abaqus", &mut |_| {}).unwrap_or_else(|e| panic!("{e}"));
    let first = convert();
    assert_eq!((convert(), store.stored_conversion(&file, "abaqus")), (first.clone(), Ok(Some(first.clone()))));
    write("*NODE\n1, 0, 0, 1\n");
    assert_eq!(store.stored_conversion(&file, "abaqus"), Ok(None));
    assert_ne!(convert(), first);
    // The surface of the file, to be meshed
    let name = || {
        let source = Source::File { path: file.clone(), unit_m: 1e-3 };
        MeshRequest { source, ..request() }.resolve(&store.home.path).expect("a good request").1
    };
    let before = name();
    write("*NODE\n1, 0, 0, 2\n");
    assert_ne!(name(), before);
}

#[test]
fn a_conversion_that_takes_too_long_has_no_key_for_its_time() {
    let (_folder, store) = project("exec sleep 60");
    let asked = serde_json::json!({ "convert": {} });
    let error = store.mesher().call(&asked, "of m.inp", 0.3, &mut |_| {}).expect_err("too long").to_string();
    assert!(error.contains("give a smaller mesh") && !error.contains("time_limit"), "{error}");
}

#[test]
fn a_file_on_which_the_mesher_crashes_cannot_be_read() {
    let (_folder, store) = project("kill -9 $$");
    let ended = |asked: serde_json::Value| {
        store.mesher().call(&asked, "of m.unv", 60.0, &mut |_| {}).expect_err("no answer").to_string()
    };
    let conversion = ended(serde_json::json!({ "convert": {} }));
    assert!(conversion.contains("the file cannot be read: write it in another format"), "{conversion}");
    let meshing = ended(serde_json::json!({}));
    assert!(meshing.contains("try another size or seed"), "{meshing}");
}

#[test]
fn unknown_names_are_refused_with_the_nearest_one() {
    let (_folder, store) = project("");
    let refuse = |r: MeshRequest| r.resolve(&store.home.path).expect_err("must be refused").to_string();
    assert_eq!(
        refuse(MeshRequest::body("rood", Size::Length(1.0))),
        "unknown body rood; did you mean `rod`? (known: rod)"
    );
    let parameters = [("lenght".to_string(), 0.1)].into();
    let source = Source::Body { name: "rod".into(), parameters };
    assert_eq!(
        refuse(MeshRequest { source, ..request() }),
        "unknown parameter of rod lenght; did you mean `length`? (known: length, phalanges, width)"
    );
    let grading = vec![Grading { near: GradedPlace::Feature("palm".into()), length: 1e-3, distance: 1e-3 }];
    assert_eq!(refuse(MeshRequest { grading, ..request() }), "unknown feature of rod palm; known: notches");
    assert_eq!(refuse(MeshRequest { order: 3, ..request() }), "mesh request: order = 3; use 1 or 2");
    let body = ParametricBody::load(&store.home.path, "rod").expect("there");
    assert_eq!(body.parse("width", "7.5 mm"), Ok(7.5e-3));
    assert_eq!(body.parse("phalanges", "3"), Ok(3.0));
    let error = body.parse("width", "7.5").expect_err("no unit").to_string();
    assert_eq!(
        error,
        "rod: parameter width: 7.5 has no unit; write the unit that is meant, \"7.5 m\" in SI or for example \"7.5 mm\""
    );
}

#[test]
fn every_way_the_mesher_can_end_has_its_error() {
    let run = |script: &str| {
        let (_folder, store) = project(&format!("cat > /dev/null\n{script}"));
        let error = message(store.mesh(&request(), &mut |_| {}));
        let left: Vec<_> = std::fs::read_dir(store.home.path.join("meshes/cache")).expect("there").collect();
        assert!(left.is_empty(), "{left:?}");
        error
    };
    let error = run(r#"echo '{"error":"width = -1","hint":"use a positive one"}'; exit 2"#);
    assert_eq!(error, "the mesher refused the request: width = -1; use a positive one");
    let error =
        run(r#"echo Meshing 3D >&2; echo '{"error":"no elements in volume 1","hint":"try another size"}'; exit 3"#);
    assert_eq!(error, "the mesher failed: no elements in volume 1; try another size; it last said:\n  Meshing 3D");
    let error = run("for i in 1 2 3 4 5 6 7 8 9 10 11 12 13; do echo line $i >&2; done; kill -9 $$");
    assert!(
        error.starts_with("the mesher stopped (signal: 9 (SIGKILL)) before it wrote a mesh; try another size or seed"),
        "{error}"
    );
    assert!(error.ends_with("line 12\n  line 13") && !error.contains("line 1\n"), "{error}");
    let error = run(r#"echo '{"error":"the mesher is not installed: No module named gmsh","hint":""}'; exit 3"#);
    assert!(
        error.ends_with("the mesher is not installed (No module named gmsh); run: durometer doctor --setup"),
        "{error}"
    );
    let limited = |script: &str, limit: f64| {
        let (_folder, store) = project(&format!("cat > /dev/null\n{script}"));
        let start = std::time::Instant::now();
        let error = message(store.mesh(&MeshRequest { time_limit_s: limit, ..request() }, &mut |_| {}));
        let left: Vec<_> = std::fs::read_dir(store.home.path.join("meshes/cache")).expect("there").collect();
        assert!(left.is_empty(), "{left:?}");
        assert!(start.elapsed().as_secs_f64() < 5.0);
        error
    };
    let error = limited("echo Meshing 3D >&2; exec sleep 60", 0.3);
    assert!(error.starts_with("the mesher was ended after its time limit of 0.3 s; ask for fewer cells"), "{error}");
    assert!(error.ends_with("it last said:\n  Meshing 3D"), "{error}");
    let error = limited("while :; do echo busy >&2; done", 0.3);
    assert!(error.starts_with("the mesher was ended after its time limit"), "{error}");
    let error = run("echo '{}'");
    assert!(error.contains("missing field") && error.contains("they are made again"), "{error}");
    let (_folder, store) = project("");
    let absent = MeshStore { python: store.home.path.join("absent"), ..store };
    let error = message(absent.mesh(&request(), &mut |_| {}));
    assert!(
        error.contains("the mesher is not installed") && error.ends_with("run: durometer doctor --setup"),
        "{error}"
    );
}

#[test]
fn the_doctor_names_the_missing_library_and_its_package() {
    let answer = r#"{"ok":false,"versions":{"cgal":"6","gmsh":"4.15.2","meshio":null},"errors":{
"gmsh":{"error":"libGLU.so.1: cannot open","missing_library":"libGLU.so","debian_package":"libglu1-mesa"},
"meshio":{"error":"No module named meshio","missing_library":null}},"fix":[]}"#;
    let script = format!("case \"$*\" in *--doctor) cat <<'END'\n{answer}\nEND\n;; -c*) echo 3.12.1;; esac");
    let (_folder, store) = project(&script);
    let checks = store.mesher().diagnose();
    let find = |what: &str| checks.iter().find(|c| c.what == what).unwrap_or_else(|| panic!("{what} in {checks:?}"));
    assert!(find("python").ok && find("meshes/meshgen").ok && find("cgal").ok && find("cgal").optional);
    let help = "apt-get install -y --no-install-recommends libglu1-mesa";
    assert_eq!((find("gmsh").ok, find("gmsh").remedy.as_deref()), (false, Some(help)));
    assert_eq!(find("meshio").remedy.as_deref(), Some("durometer doctor --setup"));
    let absent = MeshStore { python: "no-such-python".into(), ..store };
    assert!(
        absent
            .mesher()
            .diagnose()
            .iter()
            .any(|c| !c.ok && c.remedy.as_deref().is_some_and(|r| r.starts_with("apt-get")))
    );
}

#[test]
fn setup_creates_the_environment_and_says_where_it_failed() {
    // The fake venv's own Python plays pip.
    let script =
        "mkdir -p .venv/bin && printf '#!/bin/sh\\necho pip \"$@\"\\n' > .venv/bin/python && chmod +x .venv/bin/python";
    let (_folder, store) = project(script);
    let mut lines = Vec::new();
    store.mesher().setup_environment(&mut |l| lines.push(l.to_string())).unwrap_or_else(|e| panic!("{e}"));
    assert!(lines.last().is_some_and(|l| l.ends_with("-r meshes/meshgen/requirements.txt")), "{lines:?}");
    let (_folder, store) = project("echo ensurepip is not available >&2; exit 1");
    let error = store.mesher().setup_environment(&mut |_| {}).expect_err("venv fails").to_string();
    assert!(
        error.contains("-m venv .venv")
            && error.contains("ensurepip")
            && error.ends_with("apt-get install -y python3-venv"),
        "{error}"
    );
}

#[test]
fn an_unwritable_folder_is_named() {
    let (_folder, store) = project(&working());
    // A file where the cache should be: fails for every user, root included.
    std::fs::write(store.home.path.join("meshes/cache"), "").expect("writable");
    let error = message(store.mesh(&request(), &mut |_| {}));
    assert!(
        error.contains("meshes/cache") && error.ends_with("check the path, its permissions and the free space"),
        "{error}"
    );
    let mesh = structured::block(1, 1, 1, 1.0, 1.0, 1.0, crate::mesh::Order::Linear);
    let error = vtu::write_vtu(&store.home.path.join("meshes/cache/a.vtu"), &mesh, &[], &[]);
    assert!(matches!(error, Err(MeshError::Unwritable { .. })));
}
