//! Narrow gaps between parts of a mesh, which nothing joins, and parts that overlap.

use durometer::math::tensor::{Mat3, Vec3};
use durometer::mesh::gap::gap;
use durometer::mesh::overlap::overlap_of_parts;
use durometer::mesh::parts::{image, parts, side_by_side};
use durometer::mesh::{Order, TetMesh, structured::block};
use std::collections::HashMap;

/// A block of 10 mm with cells of 5 mm, and one of other divisions that is moved by so much \[mm\].
fn two(divisions: usize, shift: [f64; 3], order: Order) -> TetMesh {
    let first = block(2, 2, 2, 0.01, 0.01, 0.01, order);
    let second = block(2, divisions, divisions, 0.01, 0.01, 0.01, order);
    let second = image(&second, &Mat3::identity(), &(Vec3::from(shift) * 1e-3));
    side_by_side(&[("a".into(), first), ("b".into(), second)]).expect("two parts")
}

/// The distance and the area are those of the gap; parts farther apart, next to each other without facing, or joined have none.
#[test]
fn a_narrow_gap_is_found_and_others_are_not() {
    for order in [Order::Linear, Order::Quadratic] {
        for (divisions, width) in [(2, 0.01), (3, 0.01), (2, 0.0), (3, 0.0), (3, 0.1)] {
            let found = gap(&two(divisions, [10.0 + width, 0.0, 0.0], order)).expect("a narrow gap");
            assert!((found.distance - width * 1e-3).abs() < 1e-15 && found.pairs == 1, "{found:?}");
            assert!((found.area - 1e-4).abs() < 1e-12 && (found.at.x - 0.01).abs() < 2e-4, "{found:?}");
            match found.between_nodes {
                Some(between) => assert!(divisions == 2 && (between - width * 1e-3).abs() < 1e-15),
                None => assert_eq!(divisions, 3),
            }
        }
        for shift in [[11.0, 0.0, 0.0], [10.01, 10.01, 0.0], [10.01, 20.0, 0.0], [-30.0, 0.0, 0.0]] {
            assert_eq!(gap(&two(2, shift, order)), None, "{shift:?}");
        }
        assert_eq!(gap(&block(2, 2, 2, 0.01, 0.01, 0.01, order)), None);
    }
}

/// The same mesh with one node where several chosen ones are at one place.
fn joined(mut mesh: TetMesh, is_chosen: impl Fn(&Vec3) -> bool) -> TetMesh {
    let mut first = HashMap::new();
    let place = |p: &Vec3| [p.x, p.y, p.z].map(|x| (x * 1e9).round() as i64);
    let points = (0..).zip(&mesh.points);
    let kept: Vec<u32> =
        points.map(|(k, p)| if is_chosen(p) { *first.entry(place(p)).or_insert(k) } else { k }).collect();
    mesh.cells.iter_mut().chain(&mut mesh.facets).for_each(|node| *node = kept[*node as usize]);
    assert!(parts(&mesh).iter().all(|part| *part == 0), "common nodes make one part");
    mesh
}

/// Facets that do not fit are not joined by the nodes that they have in common, nor are sides of a slit without a width.
#[test]
fn common_nodes_do_not_hide_a_crack() {
    for order in [Order::Linear, Order::Quadratic] {
        let with_corners = joined(two(3, [10.0, 0.0, 0.0], order), |_| true);
        let found = gap(&with_corners).expect("a crack");
        assert!(found.pairs == 1 && !found.is_within_parts && found.between_nodes.is_none(), "{found:?}");
        assert!((found.area - 1e-4).abs() < 1e-12 && found.distance < 1e-15, "{found:?}");
        assert_eq!(overlap_of_parts(&with_corners), None);

        let is_low = |p: &Vec3| p.y < 5.1e-3;
        let mut slit = joined(two(2, [10.0, 0.0, 0.0], order), is_low);
        let found = gap(&slit).expect("a crack");
        assert!(found.pairs == 1 && found.is_within_parts && found.between_nodes == Some(0.0), "{found:?}");
        assert!((found.area - 5e-5).abs() < 1e-12 && found.at.y > 5e-3, "{found:?}");
        // A slit with a width is meant
        let count = slit.points.len() / 2;
        slit.points[count..].iter_mut().filter(|p| !is_low(p)).for_each(|p| p.x += 1e-5);
        assert_eq!(gap(&slit), None);
        assert_eq!(gap(&joined(two(2, [10.0, 0.0, 0.0], order), |_| true)), None);
    }
}

/// A block that reaches from the middle of another one, where both have a node, out of its corner.
#[test]
fn a_common_node_does_not_hide_an_overlap() {
    for order in [Order::Linear, Order::Quadratic] {
        let mesh = joined(two(3, [5.0; 3], order), |p| p.max() < 5.1e-3);
        let at = overlap_of_parts(&mesh).expect("an overlap");
        assert!(at.iter().all(|x| (5e-3..=10e-3).contains(x)), "{at}");
    }
}
