//! Mesh files of all formats, whole and damaged, through the world loader.

#![allow(clippy::unwrap_used, reason = "helpers of tests, not input handling")]

mod common;

use std::path::Path;

use common::{Folder, check_no_panic};
use surefoot_shared_types::scene::World;
use surefoot_shared_types::scene::load::load_world;
use surefoot_shared_types::{InputError, Shape};

const CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

fn binary_stl() -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend((FACES.len() as u32).to_le_bytes());
    for face in FACES {
        bytes.extend([0; 12]);
        face.iter().flat_map(|corner| CORNERS[*corner]).for_each(|number| bytes.extend(number.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

fn ascii_stl() -> Vec<u8> {
    let facets = FACES.map(|face| {
        let corners = face.map(|corner| format!("vertex {} {} {}\n", CORNERS[corner][0], CORNERS[corner][1], CORNERS[corner][2])).concat();
        format!("facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\n")
    });
    format!("solid t\n{}endsolid t\n", facets.concat()).into_bytes()
}

fn collada(up_axis: &str) -> Vec<u8> {
    let numbers: Vec<String> = CORNERS.as_flattened().iter().map(f32::to_string).collect();
    let indices: Vec<String> = FACES.as_flattened().iter().map(usize::to_string).collect();
    format!(
        "<?xml version=\"1.0\"?><COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" version=\"1.4.1\">\
         <asset><unit meter=\"1\"/><up_axis>{up_axis}</up_axis></asset><library_geometries><geometry id=\"g\"><mesh>\
         <source id=\"p\"><float_array id=\"a\" count=\"12\">{}</float_array><technique_common>\
         <accessor source=\"#a\" count=\"4\" stride=\"3\"><param name=\"X\" type=\"float\"/><param name=\"Y\" type=\"float\"/>\
         <param name=\"Z\" type=\"float\"/></accessor></technique_common></source>\
         <vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices>\
         <triangles count=\"4\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><p>{}</p></triangles>\
         </mesh></geometry></library_geometries></COLLADA>",
        numbers.join(" "),
        indices.join(" ")
    )
    .into_bytes()
}

fn load_as(folder: &Path, name: &str) -> Result<World, InputError> {
    let world = format!("mu = 1\n[[shapes]]\nname = \"m\"\nmesh = {{ path = \"{name}\" }}\n");
    std::fs::write(folder.join("mesh_world.toml"), world).unwrap();
    load_world(&folder.join("mesh_world.toml"))
}

#[test]
fn every_format_gives_the_same_tetrahedron() {
    let folder = Folder::new();
    for (name, bytes) in [("t.stl", binary_stl()), ("u.stl", ascii_stl()), ("t.dae", collada("Z_UP"))] {
        folder.write(name, &bytes);
        let world = load_as(&folder.path(""), name).unwrap();
        let Shape::Mesh { vertices, triangles, .. } = &world.shapes[0].shape else { panic!("{name} is not a mesh") };
        assert_eq!((vertices.len(), triangles.len()), (4, 4), "{name}");
    }
}

#[test]
fn triangles_without_area_are_dropped() {
    let folder = Folder::new();
    folder.write("t.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nf 1 2 3\nf 1 2 4\nf 1 1 2\n");
    let world = load_as(&folder.path(""), "t.obj").unwrap();
    assert!(matches!(&world.shapes[0].shape, Shape::Mesh { triangles, .. } if triangles.len() == 1));
    folder.write("t.obj", b"v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    assert!(load_as(&folder.path(""), "t.obj").unwrap_err().to_string().contains("no triangle of any area"));
}

#[test]
fn a_mesh_that_is_not_z_up_is_refused() {
    let folder = Folder::new();
    folder.write("t.dae", &collada("Y_UP"));
    let error = load_as(&folder.path(""), "t.dae").unwrap_err().to_string();
    assert!(error.contains("shape 'm'") && error.contains("not z-up"), "{error}");
}

#[test]
fn a_deeply_nested_collada_file_is_refused() {
    let folder = Folder::new();
    folder.write("t.dae", format!("<COLLADA>{}{}</COLLADA>", "<a>".repeat(100_000), "</a>".repeat(100_000)).as_bytes());
    assert!(load_as(&folder.path(""), "t.dae").unwrap_err().to_string().contains("nested deeper"));
}

#[test]
fn no_damage_panics() {
    check_no_panic("t.stl", &binary_stl(), |folder: &Path| load_as(folder, "t.stl"));
    check_no_panic("u.stl", &ascii_stl(), |folder: &Path| load_as(folder, "u.stl"));
    check_no_panic("t.dae", &collada("Z_UP"), |folder: &Path| load_as(folder, "t.dae"));
}
