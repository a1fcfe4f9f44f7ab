use durometer::scene::*;
fn main() {
    let file = std::path::PathBuf::from(std::env::args().nth(1).unwrap());
    let changes: Vec<_> = std::env::args().skip(2).map(|c| overrides::parse(&c).unwrap()).collect();
    let (spec, text) = read_scene(&file, &changes).unwrap_or_else(|e| panic!("{e}"));
    let body = body(&file, &spec.mesh).unwrap_or_else(|e| panic!("{e}"));
    let t = std::time::Instant::now();
    let scene = Scene::build(&file, spec, text, body.into()).unwrap_or_else(|e| panic!("{e}"));
    println!("build {:?}", t.elapsed());
    let run = scene.run(&mut |_| true, &mut |_| {});
    println!("{:?}", t.elapsed());
    println!("{}", run.columns.join(","));
    for r in &run.rows {
        println!("{}", r.iter().map(|v| format!("{v:.5}")).collect::<Vec<_>>().join(","));
    }
    println!(
        "{} {:?} {:?} as {:?} fac {:?} n {} solve {:?} nnz {} dofs {}",
        run.status,
        run.totals,
        run.costs,
        run.assembly,
        run.factorisation,
        run.factorisations,
        run.solve,
        run.factor_nnz,
        run.dofs
    );
}
