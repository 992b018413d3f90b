//! The positions of a COLLADA mesh: an array of numbers, and the accessor that says which of them
//! are x, y and z.

use glam::DVec3;
use roxmltree::Node;

use crate::mesh::collada_xml::{
    Ids, check_count, child, children, damaged, input, numbers, quoted, whole_number,
};

/// The positions of a mesh. Ids are looked up in the mesh alone: some exporters use the same ones
/// in every geometry.
pub(crate) fn positions(mesh: Node, vertices: Node) -> Result<Vec<DVec3>, String> {
    let ids = Ids::below(mesh);
    let source = ids.find(input(vertices, "POSITION")?, "source", "source")?;
    let accessor =
        child(source, "technique_common").and_then(|technique| child(technique, "accessor"));
    let accessor = accessor.ok_or_else(|| damaged(source, "has no <accessor>".into()))?;
    let array = ids.find(accessor, "source", "float_array")?;
    let numbers: Vec<f64> = numbers(array)?;
    check_count(array, numbers.len())?;
    let (offset, stride) =
        (whole_number(accessor, "offset", 0)?, whole_number(accessor, "stride", 1)?);
    let axes = axes(accessor)?;
    if stride <= axes[0].max(axes[1]).max(axes[2]) {
        return Err(damaged(
            accessor,
            format!("has positions of {stride} numbers each; 3 belong there"),
        ));
    }
    let items = numbers.get(offset..).unwrap_or_default().chunks(stride);
    let count = whole_number(accessor, "count", usize::MAX)?;
    let positions: Vec<DVec3> = items
        .map(|item| axes.map(|axis| item.get(axis).copied()))
        .filter_map(|[x, y, z]| Some(DVec3::new(x?, y?, z?)))
        .take(count)
        .collect();
    check_count(accessor, positions.len())?;
    Ok(positions)
}

/// Which numbers of an item are x, y and z: as its `<param>`s name them, else the first three. A
/// `<param>` without a name is one to skip.
fn axes(accessor: Node) -> Result<[usize; 3], String> {
    let names: Vec<&str> = children(accessor, "param")
        .map(|param| param.attribute("name").unwrap_or_default())
        .collect();
    if names.iter().all(|name| name.is_empty()) {
        return Ok([0, 1, 2]);
    }
    let place = |axis: &str| {
        let at = names.iter().position(|name| name.trim().eq_ignore_ascii_case(axis));
        at.ok_or_else(|| {
            let names = quoted(&names.join(" "));
            damaged(accessor, format!("has the params '{names}'; X, Y and Z belong there"))
        })
    };
    Ok([place("x")?, place("y")?, place("z")?])
}
