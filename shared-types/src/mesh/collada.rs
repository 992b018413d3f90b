//! The triangles of COLLADA files: geometries, placed by the nodes of a scene.

use std::collections::BTreeMap;

use glam::{DAffine3, DMat3, DVec3};
use roxmltree::{Document, Node};

use crate::base::spatial::rotation_about;
use crate::base::text_file::{IS_UTF16, check_positive, has_utf16_mark};
use crate::base::xml::plain_xml;
use crate::mesh::collada_geometry::{Face, geometry_faces};
use crate::mesh::collada_xml::{Ids, child, damaged, exactly, quoted};
use crate::mesh::raw_mesh::{MeshError, Welder};

/// Most children of a scene's nodes, counted at each instance: nodes that instantiate each other
/// would have no end.
const SCENE_ELEMENTS_MAX: usize = 1_000_000;
/// Most triangles of a scene; instances multiply those of the file. The largest STL file holds
/// fewer.
const TRIANGLES_MAX: usize = 1 << 25;
/// The message about scenes of which the file chooses none.
const NO_SCENE_NAMED: &str =
    "has several <visual_scene>s and names none in <scene>; export one alone";

/// Reads a file's scene, or all its geometries where it has no scene, in metres. `<up_axis>` does
/// not count: ROS takes coordinates as they stand, and its robots rely on that.
pub(crate) fn read(bytes: &[u8], welder: &mut Welder) -> Result<(), MeshError> {
    if has_utf16_mark(bytes) {
        return Err(IS_UTF16.into());
    }
    // Names in another encoding do no harm.
    let text = String::from_utf8_lossy(bytes);
    let text = plain_xml(&text).map_err(|error| MeshError::at(error.line, error.message))?;
    let document = Document::parse(&text).map_err(|error| {
        MeshError::at(error.pos().row as usize, format!("cannot be parsed as COLLADA: {error}"))
    })?;
    let root = document.root_element();
    if !root.has_tag_name("COLLADA") {
        return Err(format!("is not COLLADA: its root is <{}>", root.tag_name().name()).into());
    }
    let metres = metres_per_unit(root)?;
    check_one_unit(root, metres)?;
    let mesh_from_scene = DAffine3::from_scale(DVec3::splat(metres));
    let mut reader = Reader { ids: Ids::below(root), geometries: BTreeMap::new(), welder };
    if let Some(scene) = reader.scene(root)? {
        return Ok(reader.walk(scene, mesh_from_scene)?);
    }
    for geometry in root.descendants().filter(|node| node.has_tag_name("geometry")) {
        place(&geometry_faces(geometry)?, &mesh_from_scene, reader.welder)?;
    }
    Ok(())
}

struct Reader<'a, 'input, 'w> {
    ids: Ids<'a, 'input>,
    /// The geometries read so far, by id.
    geometries: BTreeMap<&'a str, Vec<Face>>,
    welder: &'w mut Welder,
}

impl<'a, 'input> Reader<'a, 'input, '_> {
    fn scene(&self, root: Node<'a, 'input>) -> Result<Option<Node<'a, 'input>>, String> {
        match child(root, "scene").and_then(|scene| child(scene, "instance_visual_scene")) {
            Some(instance) => self.ids.find(instance, "url", "visual_scene").map(Some),
            None => {
                let mut scenes = root.descendants().filter(|node| is_scene(*node));
                match (scenes.next(), scenes.next()) {
                    (_, Some(_)) => Err(NO_SCENE_NAMED.into()),
                    (scene, None) => Ok(scene),
                }
            }
        }
    }

    /// Places all geometries below a scene, in the order of the document. How a node stands
    /// matters only where it holds a geometry: cameras may be placed in any way.
    fn walk(&mut self, scene: Node<'a, 'input>, mesh_from_scene: DAffine3) -> Result<(), String> {
        let mut ahead = vec![(scene, Ok(mesh_from_scene))];
        let mut elements = 0;
        while let Some((node, mesh_from_parent)) = ahead.pop() {
            let mesh_from_node: Result<DAffine3, String> =
                mesh_from_parent.and_then(|parent| Ok(parent * parent_from_node(node)?));
            let siblings = ahead.len();
            for part in node.children().filter(Node::is_element) {
                elements += 1;
                if elements > SCENE_ELEMENTS_MAX {
                    return Err(format!(
                        "has a scene of more than {SCENE_ELEMENTS_MAX} elements; its <node>s may instantiate each other"
                    ));
                }
                match part.tag_name().name() {
                    "node" => ahead.push((part, mesh_from_node.clone())),
                    "instance_node" => {
                        ahead.push((self.ids.find(part, "url", "node")?, mesh_from_node.clone()))
                    }
                    "instance_geometry" => self.place_instance(part, &mesh_from_node.clone()?)?,
                    tag => check_without_surface(tag)?,
                }
            }
            ahead[siblings..].reverse();
        }
        Ok(())
    }

    fn place_instance(&mut self, instance: Node, mesh_from_node: &DAffine3) -> Result<(), String> {
        let geometry = self.ids.find(instance, "url", "geometry")?;
        let id = geometry.attribute("id").unwrap_or_default();
        if !self.geometries.contains_key(id) {
            self.geometries.insert(id, geometry_faces(geometry)?);
        }
        place(&self.geometries[id], mesh_from_node, self.welder)
    }
}

/// Refuses what may stand in a node and hold a surface that is not read.
fn check_without_surface(tag: &str) -> Result<(), String> {
    match tag {
        "instance_controller" => {
            Err("is deformed by an <instance_controller>; export it without skin or morph".into())
        }
        "matrix" | "translate" | "rotate" | "scale" | "lookat" | "skew" | "asset" | "extra"
        | "instance_camera" | "instance_light" | "evaluate_scene" => Ok(()),
        _ => Err(format!("has a <{tag}> in a <node>, which is not read; export it without")),
    }
}

/// Adds faces at their place. A mirroring one keeps their normals outward.
fn place(faces: &[Face], mesh_from_node: &DAffine3, welder: &mut Welder) -> Result<(), String> {
    let is_mirrored = mesh_from_node.matrix3.determinant() < 0.0;
    for face in faces {
        if welder.mesh.triangles.len() + face.len() > TRIANGLES_MAX {
            return Err(format!("has more than {TRIANGLES_MAX} triangles; export it coarser"));
        }
        let mut corners: Face =
            face.iter().map(|vertex| mesh_from_node.transform_point3(*vertex)).collect();
        if is_mirrored {
            corners[1..].reverse();
        }
        welder.push_polygon(&corners, None)?;
    }
    Ok(())
}

fn is_scene(node: Node) -> bool {
    node.has_tag_name("visual_scene")
}

/// Refuses a part with another unit than the file's: parts are read in that one.
fn check_one_unit(root: Node, metres: f64) -> Result<(), String> {
    let assets = root.descendants().filter(|node| node.has_tag_name("asset"));
    for part in
        assets.filter_map(|asset| asset.parent()).filter(|part| child(*part, "asset").is_some())
    {
        let own = metres_per_unit(part)?;
        if child(part, "asset").and_then(|asset| child(asset, "unit")).is_some() && own != metres {
            let tag = part.tag_name().name();
            return Err(format!("has a <{tag}> with a <unit> of its own; export it in one unit"));
        }
    }
    Ok(())
}

/// The metres of a unit of the file, or of a part of it.
fn metres_per_unit(part: Node) -> Result<f64, String> {
    let text = child(part, "asset")
        .and_then(|asset| child(asset, "unit"))
        .and_then(|unit| unit.attribute("meter"));
    let Some(text) = text else { return Ok(1.0) };
    let metres = text
        .trim()
        .parse()
        .map_err(|_| format!("has the unit meter=\"{}\", which is not a number", quoted(text)))?;
    check_positive("has a unit whose meter", &[metres])?;
    Ok(metres)
}

/// A node's transforms, of which the first to stand in the document is the outermost.
fn parent_from_node(node: Node) -> Result<DAffine3, String> {
    node.children().try_fold(DAffine3::IDENTITY, |parent_from_here, element| {
        Ok(parent_from_here * transform(element)?)
    })
}

fn transform(element: Node) -> Result<DAffine3, String> {
    match element.tag_name().name() {
        "matrix" => {
            let [xx, xy, xz, x, yx, yy, yz, y, zx, zy, zz, z, last @ ..] = exactly::<16>(element)?;
            if last != [0.0, 0.0, 0.0, 1.0] {
                return Err(damaged(
                    element,
                    format!("ends in {last:?}; [0, 0, 0, 1] belongs there"),
                ));
            }
            let linear = DMat3::from_cols_array(&[xx, yx, zx, xy, yy, zy, xz, yz, zz]);
            Ok(DAffine3::from_mat3_translation(linear, DVec3::new(x, y, z)))
        }
        "translate" => Ok(DAffine3::from_translation(DVec3::from_array(exactly(element)?))),
        "rotate" => {
            let [x, y, z, degrees] = exactly(element)?;
            let axis = DVec3::new(x, y, z)
                .try_normalize()
                .ok_or_else(|| damaged(element, "has no axis".into()))?;
            Ok(DAffine3::from_quat(rotation_about(axis, degrees.to_radians())))
        }
        "scale" => Ok(DAffine3::from_scale(DVec3::from_array(exactly(element)?))),
        tag @ ("lookat" | "skew") => {
            Err(format!("places a part by <{tag}>; export it with matrices"))
        }
        _ => Ok(DAffine3::IDENTITY),
    }
}
