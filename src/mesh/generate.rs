//! Meshes made here: rectangles and boxes.

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

/// A box cut into `cells[0] x cells[1] x cells[2]` blocks of six tetrahedra each (Kuhn's triangulation: all six share the
/// diagonal from the lowest to the highest corner, so that neighbouring blocks fit).
///
/// Boundary names: `left`, `right` (x), `bottom`, `top` (y), `back`, `front` (z), and `walls` for all of them.
pub fn box_mesh(min: [f64; 3], max: [f64; 3], cells: [usize; 3]) -> Result<Mesh<3>> {
    if cells.contains(&0) || !(0..3).all(|i| max[i] > min[i]) {
        return Err(Error::scene("a box needs max > min and at least one cell in each direction")
            .value(format!("min = {min:?}, max = {max:?}, cells = {cells:?}")));
    }
    let [nx, ny, nz] = cells;
    let coordinate = |i: usize, a: usize| min[a] + (max[a] - min[a]) * i as f64 / cells[a] as f64;
    let mut points = Vec::with_capacity((nx + 1) * (ny + 1) * (nz + 1));
    for k in 0..=nz {
        for j in 0..=ny {
            points.extend((0..=nx).map(|i| Point::<3>::new(coordinate(i, 0), coordinate(j, 1), coordinate(k, 2))));
        }
    }
    let step = [1, nx + 1, (nx + 1) * (ny + 1)];
    let mut tetrahedra = Vec::with_capacity(24 * nx * ny * nz);
    for (k, j, i) in (0..nz).flat_map(|k| (0..ny).flat_map(move |j| (0..nx).map(move |i| (k, j, i)))) {
        let corner = i * step[0] + j * step[1] + k * step[2];
        // Each order of the axes is a path along edges to the opposite corner; even orders are positively oriented.
        for [a, b, c] in [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]] {
            let path = [0, step[a], step[a] + step[b], step[a] + step[b] + step[c]].map(|s| (corner + s) as u32);
            let even = (b + 3 - a) % 3 == 1;
            tetrahedra.extend(if even { path } else { [path[0], path[2], path[1], path[3]] });
        }
    }
    let mut mesh = Mesh::new(points, tetrahedra)?;
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

    #[test]
    fn a_box_has_the_right_volume_sides_and_orientation() {
        let m = box_mesh([0.0; 3], [2.0, 1.0, 3.0], [4, 3, 5]).unwrap();
        assert!((m.volume() - 6.0).abs() < 1e-13);
        assert_eq!((m.cell_count(), m.reoriented()), (360, 0));
        assert_eq!(m.boundary("walls").unwrap().len(), 2 * 2 * (4 * 3 + 3 * 5 + 5 * 4));
        for (name, area) in [("left", 3.0), ("top", 6.0), ("front", 2.0)] {
            let part = m.boundary(name).unwrap();
            let sum: f64 = part.iter().map(|&f| m.facet_normal(&m.facets()[f as usize]).1).sum();
            assert!((sum - area).abs() < 1e-13, "{name}: {sum}");
        }
    }
}
