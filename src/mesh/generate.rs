//! Meshes made here: rectangles.

use super::{Mesh, Point};
use crate::base::{Error, Result};

/// A rectangle cut into `cells[0] x cells[1]` squares, each halved by the diagonal from its lower left to its upper
/// right corner: the pattern of FreeFEM's `square(n, m, flags = 0)`.
///
/// Boundary names: `left`, `right`, `bottom`, `top`, and `walls` for all of them.
pub fn rectangle(min: [f64; 2], max: [f64; 2], cells: [usize; 2]) -> Result<Mesh<2>> {
    let [nx, ny] = cells;
    if nx == 0 || ny == 0 || !(max[0] > min[0] && max[1] > min[1]) {
        return Err(Error::scene("a rectangle needs max > min and at least one cell in each direction")
            .value(format!("min = {min:?}, max = {max:?}, cells = {cells:?}")));
    }
    let coordinate = |i: usize, n: usize, a: usize| min[a] + (max[a] - min[a]) * i as f64 / n as f64;
    let mut points = Vec::with_capacity((nx + 1) * (ny + 1));
    for j in 0..=ny {
        for i in 0..=nx {
            points.push(Point::<2>::new(coordinate(i, nx, 0), coordinate(j, ny, 1)));
        }
    }
    let id = |i: usize, j: usize| (i + j * (nx + 1)) as u32;
    let mut tri = Vec::with_capacity(6 * nx * ny);
    for j in 0..ny {
        for i in 0..nx {
            tri.extend([id(i, j), id(i + 1, j), id(i + 1, j + 1)]);
            tri.extend([id(i, j), id(i + 1, j + 1), id(i, j + 1)]);
        }
    }
    let mut mesh = Mesh::new(points, tri)?;
    name_box_sides(&mut mesh);
    Ok(mesh)
}

/// Names the facets of an axis-aligned box `left`, `right`, `bottom`, `top` (3-D also `back`, `front`) by their normals, and all of them `walls`.
pub(crate) fn name_box_sides<const D: usize>(mesh: &mut Mesh<D>) {
    let names = ["left", "right", "bottom", "top", "back", "front"];
    let mut parts = vec![Vec::new(); 2 * D];
    for (i, f) in mesh.facets().iter().enumerate() {
        let (n, _) = mesh.facet_normal(f);
        let axis = n.iamax();
        parts[2 * axis + usize::from(n[axis] > 0.0)].push(i as u32);
    }
    let all = (0..mesh.facets().len() as u32).collect();
    for (name, part) in names.iter().zip(parts) {
        mesh.set_boundary(*name, part);
    }
    mesh.set_boundary("walls", all);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rectangle_has_the_right_area_sides_and_neighbours() {
        let m = rectangle([0.0, 0.0], [2.0, 1.0], [4, 3]).unwrap();
        assert!((m.volume() - 2.0).abs() < 1e-14);
        assert_eq!(m.cell_count(), 24);
        assert_eq!(m.boundary("walls").unwrap().len(), 14);
        let right = m.boundary("right").unwrap();
        let length: f64 = right.iter().map(|&f| m.facet_normal(&m.facets()[f as usize]).1).sum();
        assert!((length - 1.0).abs() < 1e-14);
        assert!(m.boundary("inlet").unwrap_err().to_string().contains("bottom"));
    }
}
