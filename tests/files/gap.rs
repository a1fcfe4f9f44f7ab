//! Narrow gaps between parts of a mesh, which nothing joins.

use durometer::math::tensor::{Mat3, Vec3};
use durometer::mesh::gap::gap;
use durometer::mesh::parts::{image, side_by_side};
use durometer::mesh::{Order, TetMesh, structured::block};

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
