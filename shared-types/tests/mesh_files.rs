//! Mesh files of all formats, whole and damaged, through the world loader.

#![allow(clippy::unwrap_used, reason = "helpers of tests, not input handling")]

mod common;

use std::path::Path;

use common::{Folder, check_no_panic};
use glam::DVec3;
use surefoot_shared_types::world::load::load_world;
use surefoot_shared_types::world::world::World;
use surefoot_shared_types::{InputError, Shape};

const CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

fn binary_stl() -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend((FACES.len() as u32).to_le_bytes());
    for face in FACES {
        bytes.extend([0; 12]);
        face.iter()
            .flat_map(|corner| CORNERS[*corner])
            .for_each(|number| bytes.extend(number.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

fn ascii_stl() -> Vec<u8> {
    let facets = FACES.map(|face| {
        let corners = face
            .map(|corner| {
                format!(
                    "vertex {} {} {}\n",
                    CORNERS[corner][0], CORNERS[corner][1], CORNERS[corner][2]
                )
            })
            .concat();
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
    for (name, bytes) in
        [("t.stl", binary_stl()), ("u.stl", ascii_stl()), ("t.dae", collada("Z_UP"))]
    {
        folder.write(name, &bytes);
        let world = load_as(&folder.path(""), name).unwrap();
        let Shape::Mesh { vertices, triangles, .. } = &world.shapes[0].shape else {
            panic!("{name} is not a mesh")
        };
        assert_eq!((vertices.len(), triangles.len()), (4, 4), "{name}");
    }
}

#[test]
fn triangles_without_area_are_dropped() {
    let folder = Folder::new();
    folder.write("t.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nf 1 2 3\nf 1 2 4\nf 1 1 2\n");
    let world = load_as(&folder.path(""), "t.obj").unwrap();
    assert!(
        matches!(&world.shapes[0].shape, Shape::Mesh { triangles, .. } if triangles.len() == 1)
    );
    folder.write("t.obj", b"v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    assert!(
        load_as(&folder.path(""), "t.obj")
            .unwrap_err()
            .to_string()
            .contains("no triangle of any area")
    );
}

#[test]
fn what_single_precision_would_bend_is_refused() {
    let folder = Folder::new();
    for (x, is_taken) in [(4_000, true), (400_000, false)] {
        folder
            .write("t.obj", format!("v {x}.3 0 0\nv {x}.4 0 0\nv {x}.3 1 0\nf 1 2 3\n").as_bytes());
        let loaded = load_as(&folder.path(""), "t.obj");
        assert_eq!(loaded.is_ok(), is_taken, "at {x} m");
        assert!(loaded.err().is_none_or(|error| error.to_string().contains("single precision")));
    }
}

/// A `<geometry>` of these positions. All of them use the same ids for the elements inside.
fn geometry(id: &str, positions: &str, primitive: &str) -> String {
    let numbers = positions.split_whitespace().count();
    format!(
        "<geometry id=\"{id}\"><mesh><source id=\"p\"><float_array id=\"a\" count=\"{numbers}\">{positions}</float_array>\
         <technique_common><accessor source=\"#a\" count=\"{}\" stride=\"3\"/></technique_common></source>\
         <vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices>{primitive}</mesh></geometry>",
        numbers / 3
    )
}

/// One triangle with corners at 0, x and y.
fn corner_triangle(id: &str) -> String {
    geometry(
        id,
        "0 0 0 1 0 0 0 1 0",
        "<triangles count=\"1\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><p>0 1 2</p></triangles>",
    )
}

fn collada_scene(geometries: &str, library_nodes: &str, nodes: &str) -> String {
    format!(
        "<COLLADA><asset><unit meter=\"1\"/></asset><library_geometries>{geometries}</library_geometries>\
         <library_nodes>{library_nodes}</library_nodes>\
         <library_visual_scenes><visual_scene id=\"other\"/><visual_scene id=\"s\">{nodes}</visual_scene></library_visual_scenes>\
         <scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>"
    )
}

/// A file with most of what a scene can hold, for tests to spoil.
fn rich_collada() -> String {
    collada_scene(
        &corner_triangle("g"),
        "<node id=\"n\"><translate>0 0 5</translate><instance_geometry url=\"#g\"/></node>",
        "<node><matrix>0 -1 0 10 1 0 0 20 0 0 1 30 0 0 0 1</matrix>\
         <node><translate>1 2 3</translate><rotate>0 0 1 90</rotate><scale>2 3 4</scale><instance_geometry url=\"#g\"/></node>\
         <instance_node url=\"#n\"/></node>",
    )
}

/// The triangles that a COLLADA file is read as.
fn triangles(text: &str) -> Vec<[DVec3; 3]> {
    let folder = Folder::new();
    folder.write("t.dae", text.as_bytes());
    let world =
        load_as(&folder.path(""), "t.dae").unwrap_or_else(|error| panic!("{error}: {text}"));
    let Shape::Mesh { vertices, triangles, .. } = &world.shapes[0].shape else {
        panic!("not a mesh")
    };
    triangles.iter().map(|triangle| triangle.map(|index| vertices[index as usize])).collect()
}

fn assert_are_near(found: &[[DVec3; 3]], wanted: &[[[f64; 3]; 3]]) {
    let wanted: Vec<DVec3> =
        wanted.as_flattened().iter().map(|vertex| DVec3::from_array(*vertex)).collect();
    let found = found.as_flattened();
    let is_near = found.len() == wanted.len()
        && found.iter().zip(&wanted).all(|(a, b)| (a - b).length() < 1e-12);
    assert!(is_near, "{found:?} instead of {wanted:?}");
}

#[test]
fn the_up_axis_of_collada_does_not_count() {
    let [x, y, z] = ["X_UP", "Y_UP", "Z_UP"]
        .map(|up_axis| triangles(&String::from_utf8(collada(up_axis)).unwrap()));
    assert_eq!(z[0], [0, 2, 1].map(|corner| DVec3::from_array(CORNERS[corner].map(f64::from))));
    assert!(x == z && y == z, "{x:?} {y:?} {z:?}");
}

#[test]
fn collada_nodes_place_their_geometries_in_order_and_from_the_outside_in() {
    let nested = [[8.0, 21.0, 33.0], [6.0, 21.0, 33.0], [8.0, 18.0, 33.0]];
    let instantiated = [[10.0, 20.0, 35.0], [10.0, 21.0, 35.0], [9.0, 20.0, 35.0]];
    assert_are_near(&triangles(&rich_collada()), &[nested, instantiated]);
    let without_scene_element =
        rich_collada().replace("<scene><instance_visual_scene url=\"#s\"/></scene>", "");
    let first_scene = without_scene_element.replace("<visual_scene id=\"other\"/>", "");
    assert_are_near(&triangles(&first_scene), &[nested, instantiated]);
}

#[test]
fn a_collada_node_is_placed_at_each_of_its_instances() {
    let step =
        |at: &str| format!("<node><translate>{at}</translate><instance_node url=\"#n\"/></node>");
    let library =
        "<node id=\"n\"><translate>0 0 1</translate><instance_geometry url=\"#g\"/></node>";
    let text = collada_scene(&corner_triangle("g"), library, &(step("2 0 0") + &step("0 3 0")));
    let wanted = [
        [[2.0, 0.0, 1.0], [3.0, 0.0, 1.0], [2.0, 1.0, 1.0]],
        [[0.0, 3.0, 1.0], [1.0, 3.0, 1.0], [0.0, 4.0, 1.0]],
    ];
    assert_are_near(&triangles(&text), &wanted);
}

#[test]
fn a_mirroring_collada_node_keeps_the_normals_outward() {
    let text = collada_scene(
        &corner_triangle("g"),
        "",
        "<node><scale>-1 1 1</scale><instance_geometry url=\"#g\"/></node>",
    );
    assert_are_near(&triangles(&text), &[[[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]]);
}

#[test]
fn each_collada_geometry_has_its_own_sources() {
    let other = corner_triangle("h").replace("0 0 0 1 0 0 0 1 0", "0 0 7 1 0 7 0 1 7");
    let nodes = "<node><instance_geometry url=\"#g\"/><instance_geometry url=\"#h\"/></node>";
    let wanted = [0.0, 7.0].map(|z| [[0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]]);
    assert_are_near(
        &triangles(&collada_scene(&(corner_triangle("g") + &other), "", nodes)),
        &wanted,
    );
}

#[test]
fn the_unit_of_collada_scales() {
    let text = rich_collada().replace("meter=\"1\"", "meter=\"0.01\"");
    let wanted = triangles(&rich_collada())
        .iter()
        .map(|corners| corners.map(|corner| (corner * 0.01).to_array()))
        .collect::<Vec<_>>();
    assert_are_near(&triangles(&text), &wanted);
}

#[test]
fn an_accessor_of_collada_skips_its_offset() {
    let text = rich_collada()
        .replace("count=\"9\">0 0 0 1 0 0 0 1 0<", "count=\"12\">9 0 0 0 9 1 0 0 9 0 1 0<")
        .replace("count=\"3\" stride=\"3\"", "count=\"3\" stride=\"4\" offset=\"1\"");
    assert_eq!(triangles(&text), triangles(&rich_collada()));
}

#[test]
fn every_primitive_of_collada_gives_the_same_square_and_triangle() {
    let vertex = "<input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/>";
    let mixed = "<input semantic=\"NORMAL\" source=\"#p\" offset=\"0\"/><input semantic=\"VERTEX\" source=\"#v\" offset=\"1\"/>";
    let primitives = [
        format!("<triangles count=\"3\">{vertex}<p>0 1 2 0 2 3 3 2 4</p></triangles>"),
        format!(
            "<triangles count=\"3\">{mixed}<p>9 0 9 1 9 2 9 0 9 2 9 3 9 3 9 2 9 4</p></triangles>"
        ),
        format!(
            "<polylist count=\"2\">{vertex}<vcount>4 3</vcount><p>0 1 2 3 3 2 4</p></polylist>"
        ),
        format!("<polygons count=\"2\">{vertex}<p>0 1 2 3</p><p>3 2 4</p></polygons>"),
        format!("<trifans count=\"2\">{vertex}<p>0 1 2 3</p><p>3 2 4</p></trifans>"),
        format!(
            "<tristrips count=\"1\">{vertex}<p>0 1 3 2 4</p></tristrips><lines count=\"1\">{vertex}<p>0 1</p></lines>"
        ),
    ];
    for primitive in primitives {
        let square = geometry("g", "0 0 0 1 0 0 1 1 0 0 1 0 0 2 0", &primitive);
        let found =
            triangles(&collada_scene(&square, "", "<node><instance_geometry url=\"#g\"/></node>"));
        let double_areas: Vec<DVec3> = found.iter().map(|[a, b, c]| (b - a).cross(c - a)).collect();
        assert_eq!(double_areas, [DVec3::Z; 3], "{primitive}");
    }
}

#[test]
fn damaged_or_unknown_collada_is_refused() {
    let cases = [
        ("<p>0 1 2</p>", "<p>0 1 3</p>", "vertex 3 of 3"),
        ("<p>0 1 2</p>", "<p>0 1 -1</p>", "'-1' for a number"),
        ("<p>0 1 2</p>", "<p>0 1</p>", "fewer corners"),
        (
            "<triangles count=\"1\"",
            "<triangles count=\"4000000000\"",
            "count=\"4000000000\" but holds 1",
        ),
        ("source=\"#v\" offset=\"0\"", "source=\"#v\" offset=\"1\"", "3 indices, 2 for each"),
        (
            "<float_array id=\"a\" count=\"9\"",
            "<float_array id=\"a\" count=\"10\"",
            "count=\"10\" but holds 9",
        ),
        ("count=\"3\" stride=\"3\"", "count=\"18446744073709551615\" stride=\"3\"", "but holds 3"),
        ("count=\"3\" stride=\"3\"", "count=\"3\" stride=\"18446744073709551615\"", "but holds 1"),
        ("stride=\"3\"", "stride=\"0\"", "0 numbers each"),
        ("<source id=\"p\">", "<source id=\"q\">", "the <source> '#p', which is not there"),
        (
            "semantic=\"VERTEX\" source=\"#v\"",
            "semantic=\"VERTEX\" source=\"#w\"",
            "does not refer to the <vertices>",
        ),
        ("semantic=\"POSITION\"", "semantic=\"NORMAL\"", "no <input semantic=\"POSITION\">"),
        ("url=\"#g\"", "url=\"parts.dae#g\"", "the <geometry> 'parts.dae#g', which is not there"),
        (
            "<instance_visual_scene url=\"#s\"",
            "<instance_visual_scene url=\"#t\"",
            "the <visual_scene> '#t'",
        ),
        ("0 0 0 1</matrix>", "0 0 1</matrix>", "holds 15 numbers instead of 16"),
        ("0 0 0 1</matrix>", "0 0 1 1</matrix>", "belongs there"),
        ("<scale>2 3 4", "<scale>2 3 x", "'x' for a number"),
        ("<scale>2 3 4", "<scale>2 3 nan", "not finite"),
        ("<rotate>0 0 1 90", "<rotate>0 0 0 90", "no axis"),
        ("<scale>2 3 4</scale>", "<skew>45 1 0 0 0 1 0</skew>", "by <skew>"),
        ("meter=\"1\"", "meter=\"0\"", "must be positive"),
        (
            "<instance_geometry",
            "<instance_controller url=\"#c\"/><instance_geometry",
            "without skin",
        ),
        ("<p>0 1 2</p>", "<ph><p>0 1 2</p><h>0 1 2</h></ph>", "holes"),
        (
            "</node></library_nodes>",
            "<instance_node url=\"#n\"/></node></library_nodes>",
            "instantiate each other",
        ),
    ];
    for (from, to, complaint) in cases {
        let good = rich_collada();
        assert!(good.contains(from), "{from}");
        let folder = Folder::new();
        folder.write("t.dae", good.replace(from, to).as_bytes());
        match load_as(&folder.path(""), "t.dae") {
            Ok(_) => panic!("{to} was accepted"),
            Err(error) => assert!(error.to_string().contains(complaint), "{to}: {error}"),
        }
    }
}

#[test]
fn a_deeply_nested_collada_file_is_refused() {
    let folder = Folder::new();
    folder.write(
        "t.dae",
        format!("<COLLADA>{}{}</COLLADA>", "<a>".repeat(100_000), "</a>".repeat(100_000))
            .as_bytes(),
    );
    assert!(load_as(&folder.path(""), "t.dae").unwrap_err().to_string().contains("nested deeper"));
}

#[test]
fn no_damage_panics() {
    check_no_panic("t.stl", &binary_stl(), |folder: &Path| load_as(folder, "t.stl"));
    check_no_panic("u.stl", &ascii_stl(), |folder: &Path| load_as(folder, "u.stl"));
    check_no_panic("u.dae", &collada("Z_UP"), |folder: &Path| load_as(folder, "u.dae"));
    check_no_panic("t.dae", rich_collada().as_bytes(), |folder: &Path| load_as(folder, "t.dae"));
    check_no_panic("t.obj", common::FOOT_OBJ.as_bytes(), |folder: &Path| load_as(folder, "t.obj"));
}
