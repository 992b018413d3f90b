//! The geometries of COLLADA files: positions and the faces between them.

use glam::DVec3;
use roxmltree::Node;

use crate::mesh::accessor::positions;
use crate::mesh::collada_xml::{
    check_count, child, children, damaged, input, numbers, quoted, whole_number,
};

/// A face: the positions of its corners, in the geometry's frame and unit.
pub(crate) type Face = Vec<DVec3>;

/// The faces of a `<geometry>`.
pub(crate) fn geometry_faces(geometry: Node) -> Result<Vec<Face>, String> {
    let Some(mesh) = child(geometry, "mesh") else {
        // A spline is a curve: no surface.
        if child(geometry, "spline").is_some() {
            return Ok(Vec::new());
        }
        let id = geometry.attribute("id").unwrap_or_default();
        return Err(format!(
            "has a <geometry> '{}' that is not a <mesh>; export it as triangles",
            quoted(id)
        ));
    };
    let vertices =
        child(mesh, "vertices").ok_or_else(|| damaged(mesh, "has no <vertices>".into()))?;
    let positions = positions(mesh, vertices)?;
    let mut placed = Vec::new();
    for primitive in mesh.children().filter(Node::is_element) {
        let position = |index: &u32| {
            let vertex = positions.get(*index as usize);
            vertex.copied().ok_or_else(|| {
                damaged(primitive, format!("has a corner at vertex {index} of {}", positions.len()))
            })
        };
        for face in faces(primitive, vertices)? {
            if face.len() < 3 {
                let complaint = format!("has a face of {} corners; it needs 3 or more", face.len());
                return Err(damaged(primitive, complaint));
            }
            placed.push(face.iter().map(position).collect::<Result<_, _>>()?);
        }
    }
    Ok(placed)
}

/// The faces of a primitive, by the indices of their vertices.
fn faces(primitive: Node, vertices: Node) -> Result<Vec<Vec<u32>>, String> {
    let tag = primitive.tag_name().name();
    match tag {
        "triangles" | "polylist" | "polygons" | "trifans" | "tristrips" => {}
        "source" | "vertices" | "lines" | "linestrips" | "extra" | "asset" => return Ok(Vec::new()),
        _ => return Err(format!("has a <{tag}> in a <mesh>; export it as triangles")),
    }
    if child(primitive, "ph").is_some() {
        return Err("has polygons with holes (<ph>); export it as triangles".into());
    }
    let lists = corner_lists(primitive, vertices)?;
    if matches!(tag, "triangles" | "polylist") {
        let corners = lists.concat();
        return Ok(polygons(primitive, &corners)?.into_iter().map(<[u32]>::to_vec).collect());
    }
    check_count(primitive, lists.len())?;
    if tag == "polygons" {
        return Ok(lists);
    }
    if let Some(short) = lists.iter().find(|list| list.len() < 3) {
        let complaint = format!("has a strip or fan of {} corners", short.len());
        return Err(damaged(primitive, complaint));
    }
    let lists = lists.iter().map(Vec::as_slice);
    Ok(if tag == "tristrips" {
        lists.flat_map(strip).map(Vec::from).collect()
    } else {
        lists.flat_map(fan).map(Vec::from).collect()
    })
}

/// The vertices in each `<p>` of a primitive, without the indices of normals and the like between
/// them.
fn corner_lists(primitive: Node, vertices: Node) -> Result<Vec<Vec<u32>>, String> {
    let vertex_input = input(primitive, "VERTEX")?;
    if vertex_input.attribute("source").and_then(|url| url.strip_prefix('#'))
        != vertices.attribute("id")
    {
        return Err(damaged(primitive, "does not refer to the <vertices> of its mesh".into()));
    }
    let vertex_offset = whole_number(vertex_input, "offset", 0)?;
    let mut stride = 1;
    for input in children(primitive, "input") {
        stride = stride.max(whole_number(input, "offset", 0)?.saturating_add(1));
    }
    let corners = |p: Node| {
        let indices: Vec<u32> = numbers(p)?;
        if !indices.len().is_multiple_of(stride) {
            return Err(damaged(
                primitive,
                format!("has {} indices, {stride} for each corner", indices.len()),
            ));
        }
        Ok(indices.into_iter().skip(vertex_offset).step_by(stride).collect())
    };
    children(primitive, "p").map(corners).collect()
}

/// Cuts the corners of a `<triangles>` or `<polylist>` into its polygons.
fn polygons<'c>(primitive: Node, mut corners: &'c [u32]) -> Result<Vec<&'c [u32]>, String> {
    let sizes = match child(primitive, "vcount") {
        Some(vcount) => numbers(vcount)?,
        None => vec![3; corners.len().div_ceil(3)],
    };
    check_count(primitive, sizes.len())?;
    let mut polygons = Vec::new();
    for size in sizes {
        let cut = corners.split_at_checked(size);
        let (polygon, rest) = cut
            .ok_or_else(|| damaged(primitive, "has fewer corners than its polygons need".into()))?;
        polygons.push(polygon);
        corners = rest;
    }
    match corners.len() {
        0 => Ok(polygons),
        left => Err(damaged(primitive, format!("has {left} corners that belong to no polygon"))),
    }
}

fn fan(corners: &[u32]) -> impl Iterator<Item = [u32; 3]> {
    corners.windows(2).skip(1).map(|pair| [corners[0], pair[0], pair[1]])
}

/// The triangles of a strip, every other one turned round so that all face the same way.
fn strip(corners: &[u32]) -> impl Iterator<Item = [u32; 3]> {
    corners
        .windows(3)
        .enumerate()
        .map(|(at, of)| if at % 2 == 0 { [of[0], of[1], of[2]] } else { [of[0], of[2], of[1]] })
}
