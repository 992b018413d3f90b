//! Mesh files of every dialect are read whole or refused; nothing of them is dropped.

#![allow(clippy::unwrap_used, reason = "helpers of tests, not input handling")]

mod common;

use std::path::Path;

use common::Folder;
use glam::DVec3;
use surefoot_shared_types::Shape;
use surefoot_shared_types::world::load::load_world;

type Triangles = Vec<[DVec3; 3]>;

/// What a file becomes in a world, or why not. `scale` is what the world file says of it.
fn load_as(folder: &Path, name: &str, scale: &str) -> Result<Triangles, String> {
    let world = format!("mu = 1\n[[shapes]]\nname = \"m\"\nmesh = {{ path = '{name}'{scale} }}\n");
    std::fs::write(folder.join("mesh_world.toml"), world).unwrap();
    let world = load_world(&folder.join("mesh_world.toml")).map_err(|error| error.to_string())?;
    let Shape::Mesh { vertices, triangles, .. } = &world.shapes[0].shape else {
        panic!("{name} is no mesh")
    };
    Ok(triangles.iter().map(|of| of.map(|index| vertices[index as usize])).collect())
}

fn load(name: &str, bytes: &[u8]) -> Result<Triangles, String> {
    let folder = Folder::new();
    folder.write(name, bytes);
    load_as(&folder.path(""), name, "")
}

fn refused(name: &str, bytes: impl AsRef<[u8]>, parts: &[&str]) {
    let text = String::from_utf8_lossy(bytes.as_ref()).into_owned();
    match load(name, bytes.as_ref()) {
        Ok(_) => panic!("{name} was accepted: {text}"),
        Err(error) => {
            assert_eq!(error.lines().count(), 1, "{error}");
            for part in parts {
                assert!(error.contains(part), "'{part}' is not in: {error}\n{text}");
            }
        }
    }
}

fn area(triangles: &[[DVec3; 3]]) -> DVec3 {
    triangles.iter().map(|[a, b, c]| 0.5 * (b - a).cross(c - a)).sum()
}

const FACET: &str =
    "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";

fn binary_stl(header: &[u8], claimed: u32, triangles: usize) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.resize(80, b' ');
    bytes.extend(claimed.to_le_bytes());
    for at in 0..triangles {
        bytes.extend([0; 12]);
        let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        for [x, y] in corners {
            [x, y, at as f32].iter().for_each(|number: &f32| bytes.extend(number.to_le_bytes()));
        }
        bytes.extend([0; 2]);
    }
    bytes
}

#[test]
fn stl_dialects_are_read() {
    let two = format!(
        "solid a\n{FACET}endsolid a\nsolid b\n{}endsolid b\n",
        FACET.replace(" 0\n", " 2\n")
    );
    let dialects = [
        format!("solid x\n{FACET}endsolid x\n"),
        format!("SOLID X\n{}ENDSOLID X\n", FACET.to_uppercase()),
        format!("Solid Unity Mesh\n{FACET}endsolid x"),
        format!("solid\n{FACET}endsolid\n\n  \t\n"),
        format!("\u{feff}solid Fuß\n{FACET}endsolid Fuß\n"),
        format!("solid x\n{FACET}end solid x\n").replace("endloop", "end loop"),
        format!(
            "  solid x\r\n{}endsolid x\r\n",
            FACET.replace('\n', "\r\n").replace("vertex", "\t vertex")
        ),
        format!("solid x\n{}endsolid x\n", FACET.replace("0 0 1", "-nan(ind) 1.#QNAN nan")),
        format!("solid x\n{FACET}endsolid x\n").replace('\n', "\r"),
    ];
    for dialect in &dialects {
        let triangles =
            load("t.stl", dialect.as_bytes()).unwrap_or_else(|e| panic!("{e}: {dialect}"));
        assert_eq!(area(&triangles), DVec3::Z * 0.5, "{dialect}");
    }
    assert_eq!(load("t.STL", two.as_bytes()).unwrap().len(), 2);
    for ending in ["STL", "Stl", "stL"] {
        assert!(load(&format!("t.{ending}"), dialects[0].as_bytes()).is_ok());
    }
    let latin = [b"solid Fu\xdf\n".as_slice(), FACET.as_bytes(), b"endsolid\n"].concat();
    assert!(load("t.stl", &latin).is_ok());
}

#[test]
fn binary_stl_files_hold_what_they_claim() {
    assert_eq!(load("t.stl", &binary_stl(b"made by hand", 2, 2)).unwrap().len(), 2);
    assert_eq!(load("t.stl", &binary_stl(b"solid but binary", 2, 2)).unwrap().len(), 2);
    assert_eq!(load("t.stl", &binary_stl(b"ply", 2, 2)).unwrap().len(), 2);
    assert_eq!(load("t.stl", &binary_stl(b"\xef\xbb\xbfby hand", 2, 2)).unwrap().len(), 2);
    let padded = [binary_stl(b"", 2, 2), vec![0; 100]].concat();
    assert_eq!(load("t.stl", &padded).unwrap().len(), 2);
    refused("t.stl", binary_stl(b"", 6, 2), &["says that it holds 6 triangles", "for 2 only"]);
    refused("t.stl", binary_stl(b"solid x", 6, 2), &["6 triangles"]);
    refused("t.stl", binary_stl(b"", u32::MAX, 2), &["4294967295"]);
    refused("t.stl", binary_stl(b"", 1, 2), &["1 triangles", "50 bytes follow"]);
    refused("t.stl", [binary_stl(b"", 2, 2), vec![7; 3]].concat(), &["3 bytes follow"]);
    refused("t.stl", binary_stl(b"", 0, 0), &["holds no triangles"]);
    refused("t.stl", [b' '; 80], &["holds no triangles"]);
    refused("t.stl", b"", &["is empty"]);
    let mut not_finite = binary_stl(b"", 1, 1);
    not_finite[96..100].copy_from_slice(&f32::NAN.to_le_bytes());
    refused("t.stl", not_finite, &["not finite"]);
}

#[test]
fn damaged_stl_texts_are_refused_with_their_line() {
    let text = |facet: &str, end: &str| format!("solid x\n{facet}{end}");
    for (bad, parts) in [
        (text(FACET, ""), ["t.stl:8", "ends within a solid"]),
        (text(FACET, "endsolid x\nrubbish\n"), ["t.stl:10", "'rubbish'"]),
        (text(&FACET.replace("1 0 0", "1 0,5 0"), "endsolid\n"), ["t.stl:5", "'0,5'"]),
        (text(&FACET.replace("vertex 1 0 0\n", ""), "endsolid\n"), ["t.stl:6", "'endloop'"]),
        (
            text(&FACET.replace("endloop", "vertex 1 1 0\nendloop"), "endsolid"),
            ["t.stl:7", "'vertex'"],
        ),
        (text(&FACET.replace("1 0 0", "1 0 1e99"), "endsolid\n"), ["t.stl:8", "not finite"]),
        (format!("solid x facet normal 0 0 1\n{FACET}endsolid"), ["t.stl:1", "'facet'"]),
        (text("", "endsolid\n"), ["t.stl", "holds no triangles"]),
        (format!("# by a program\n{}", text(FACET, "endsolid")), ["t.stl", "begin with 'solid'"]),
    ] {
        refused("t.stl", bad, &parts);
    }
}

const QUAD: &str = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\n";

#[test]
fn obj_lines_are_read_as_the_format_says() {
    let dialects = [
        format!("{QUAD}f 1 2 3 4\n"),
        format!("{QUAD}\tf 1 2 3 4"),
        format!("  {}  f 1 2 3 4\r\n", QUAD.replace('\n', "\r\n\t")),
        format!("{QUAD}f -4 -3 -2 -1\n"),
        format!("f 1 2 3 4\n{QUAD}"),
        format!("{QUAD}f 1 2 \\\n3 4\n"),
        format!("{}f 1 2 3 4 # a floor\n", QUAD.replace("v 2 0 0", "v 2 \\\n 0 \\\r\n0")),
        format!(
            "\u{feff}# x\nmtllib a.mtl\no a\ng b c\ns off\nusemtl #1\n{QUAD}vt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3//1 4/1\nl 1 2\np 1\n"
        ),
        format!("{}fo 1 2 3 4\n", QUAD.replace(" 0\n", " 0 1.0\n")),
        format!("{}f 1 2 3 4\n", QUAD.replace(" 0\n", " 0 0.5 0.5 0.5\n")),
        format!("{QUAD}f 1 1 2 3 4 4\nf 1 2 1 2\nf 1 1 1\n"),
        format!("# by a program\n{QUAD}g a\nf 1 2 3 4\n").replace('\n', "\r"),
        format!("# a\r{QUAD}# b\rf 1 2 3 4\n"),
        format!("# C:\\models\\\n# more\n{QUAD}g a \\\nb\nusemtl \\\n\nf 1 2 3 4\n# the end \\"),
    ];
    for dialect in &dialects {
        let triangles =
            load("t.obj", dialect.as_bytes()).unwrap_or_else(|e| panic!("{e}: {dialect}"));
        assert_eq!(area(&triangles), DVec3::Z * 2.0, "{dialect}");
    }
    for ending in ["OBJ", "Obj", "oBj"] {
        assert!(load(&format!("t.{ending}"), dialects[0].as_bytes()).is_ok());
    }
}

#[test]
fn what_obj_cannot_hold_is_refused_with_its_line() {
    for (line, parts) in [
        ("f 1 2", ["t.obj:5", "2 corners"]),
        ("f 1 2 5", ["t.obj:5", "vertex 5 of 4"]),
        ("f 0 1 2", ["t.obj:5", "count from 1"]),
        ("f -5 1 2", ["t.obj:5", "'-5'"]),
        ("f -9223372036854775808 1 2", ["t.obj:5", "4 vertices"]),
        ("f 1 2 3.0", ["t.obj:5", "'3.0'"]),
        ("f 1/x 2 3", ["t.obj:5", "'1/x'"]),
        ("f 1/1/1/1 2 3", ["t.obj:5", "'1/1/1/1'"]),
        ("v 1 2", ["t.obj:5", "2 numbers"]),
        ("v 1 2 3 4 5", ["t.obj:5", "5 numbers"]),
        ("v 1 2 3 2", ["t.obj:5", "weight 2"]),
        ("v 1 2 x", ["t.obj:5", "'x'"]),
        ("v 1 2 inf", ["t.obj:5", "not finite"]),
        ("face 1 2 3", ["t.obj:5", "'face'"]),
        ("F 1 2 3", ["t.obj:5", "'F'"]),
        ("surf 0 1 0 1 1 2 3 4", ["t.obj:5", "free-form surface"]),
        ("call other.obj", ["t.obj:5", "'call'"]),
        ("# C:\\models\\", ["t.obj:5", "remove the '\\'"]),
        ("# C:\\models\\\n# more \\", ["t.obj:5", "remove the '\\'"]),
        ("g C:\\models\\", ["t.obj:5", "remove the '\\'"]),
        ("mtllib C:\\models\\\nv 0 0 0", ["t.obj:5", "remove the '\\'"]),
    ] {
        refused("t.obj", format!("{QUAD}{line}\nf 1 2 3\n"), &parts);
    }
    refused("t.obj", QUAD, &["holds no triangles"]);
    refused("t.obj", b"\xff\xfev\0 \0", &["UTF-16"]);
}

/// A floor of 4 by 2 with a notch cut into it, as one face that begins anywhere.
fn notched(start: usize) -> String {
    let mut corners = ["0 0", "4 0", "4 2", "2.2 2", "2.2 0.5", "2 0.5", "2 2", "0 2"]
        .map(|at| format!("v {at} 0\n"));
    corners.rotate_left(start);
    corners.concat() + "f 1 2 3 4 5 6 7 8\n"
}

#[test]
fn concave_faces_are_cut_as_they_are() {
    for start in 0..8 {
        let triangles = load("t.obj", notched(start).as_bytes()).unwrap();
        let whole: f64 = triangles.iter().map(|of| area(&[*of]).length()).sum();
        assert!((area(&triangles) - DVec3::Z * 7.7).length() < 1e-6, "{start}");
        assert!((whole - 7.7).abs() < 1e-6, "corner {start}: {whole}");
    }
    let comb: String =
        (0..100).map(|at| format!("v {at} {} 0\n", if at % 2 == 0 { 1 } else { 5 })).collect();
    let face: String = (1..=102).map(|at| format!(" {at}")).collect();
    let triangles =
        load("t.obj", format!("v 0 0 0\n{comb}v 99 0 0\nf{face}\n").as_bytes()).unwrap();
    assert!((area(&triangles).length() - 99.0 * 3.0).abs() < 1e-6 && triangles.len() == 100);
}

#[test]
fn faces_without_a_plane_are_no_surface() {
    let bent = QUAD.replace("v 2 1 0", "v 2 1 0.1");
    refused("t.obj", format!("{bent}f 1 2 3 4\n"), &["t.obj:5", "mm off its plane", "triangles"]);
    assert!(
        load("t.obj", format!("{}f 1 2 3 4\n", QUAD.replace("v 2 1 0", "v 2 1 1e-4")).as_bytes())
            .is_ok()
    );
    refused("t.obj", format!("{QUAD}f 1 3 2 4\n"), &["t.obj:5", "crosses itself"]);
}

#[test]
fn a_double_sided_sheet_has_one_upper_side() {
    let both = format!("{QUAD}f 1 2 3 4\nf 4 3 2 1\n");
    assert_eq!(area(&load("t.obj", both.as_bytes()).unwrap()), DVec3::Z * 2.0);
    let other_cut = format!("{QUAD}f 1 2 3\nf 1 3 4\nf 2 1 4\nf 3 2 4\n");
    assert_eq!(area(&load("t.obj", other_cut.as_bytes()).unwrap()), DVec3::Z * 2.0);
}

#[test]
fn formats_that_are_not_read_are_called_by_their_names() {
    for (name, bytes, what) in [
        ("a.ply", &b"ply\nformat ascii 1.0\n"[..], "is a PLY file"),
        ("a.OFF", b"OFF\n3 1 0\n", "is an OFF file"),
        ("a.glb", b"glTF", "is a binary glTF file"),
        ("a.gltf", b"{}", "is a glTF file"),
        ("a.wrl", b"#VRML V2.0 utf8\n", "is a VRML file"),
        ("a.x3d", b"<?xml version=\"1.0\"?><X3D/>", "is an X3D file"),
        ("a.fbx", b"Kaydara FBX Binary  \0", "is an FBX file"),
        ("a.stp", b"ISO-10303-21;", "is a STEP file"),
        ("a.obj", b"OFF\n3 1 0\n", "is an OFF file"),
        ("a.dae", b"glTF\x02\0\0\0", "is a binary glTF file"),
        ("a.unknown", b"abc", "ends in '.unknown'"),
        ("a", b"abc", "not read"),
    ] {
        refused(name, bytes, &[what, "STL, OBJ or COLLADA"]);
    }
    refused(
        "a.stl",
        b"version https://git-lfs.github.com/spec/v1\n",
        &["Git LFS pointer", "git lfs pull"],
    );
    for page in ["<!DOCTYPE html><html>404</html>", "<!doctype html>\n", "<html></html>"] {
        for name in ["a.stl", "a.obj", "a.dae", "a.unknown"] {
            refused(name, page.repeat(9), &["is a web page, not the mesh itself; fetch the file"]);
        }
    }
    refused("a.obj", format!("solid x\n{FACET}endsolid\n"), &["STL file by its content"]);
    refused("a.stl", format!("{QUAD}f 1 2 3 4\n"), &["OBJ file by its content; name it .obj"]);
    refused("a.dae", format!("{QUAD}f 1 2 3 4\n"), &["OBJ file by its content"]);
    refused("a.obj", format!("{QUAD}f 1 2 3 9\n"), &["vertex 9 of 4"]);
    refused("a", "abc", &["has no ending"]);
}

#[test]
fn archives_are_to_be_unpacked() {
    for (name, bytes, what) in [
        ("a.stl", &b"\x1f\x8b\x08\0\0\0\0\0"[..], "is a gzip archive; unpack it"),
        ("a.obj.gz", b"\x1f\x8b\x08\0\0\0\0\0", "is a gzip archive"),
        ("a.dae", b"PK\x03\x04\x14\0", "is a ZIP archive; unpack it"),
        ("a.3mf", b"PK\x03\x04\x14\0", "is a 3MF file"),
        ("a.obj", b"BZh91AY&SY", "is a bzip2 archive"),
        ("a.stl", b"\xfd7zXZ\0\0\x04", "is an xz archive"),
        ("a.stl", b"\x28\xb5\x2f\xfd\x24", "is a zstd archive"),
    ] {
        refused(name, bytes, &[what]);
    }
}

#[test]
fn millimetres_are_asked_about() {
    let huge = QUAD.replace('2', "6000").replace(" 1 ", " 3000 ") + "f 1 2 3 4\n";
    refused("t.obj", &huge, &["mesh_world.toml:2", "millimetres? set scale = 0.001"]);
    let middling = QUAD.replace('2', "2000") + "f 1 2 3 4\n";
    refused("t.obj", &middling, &["2000 m across: millimetres? set scale = 0.001"]);
    let folder = Folder::new();
    folder.write("t.obj", middling.as_bytes());
    let scaled = |scale: &str| load_as(&folder.path(""), "t.obj", scale).map(|it| area(&it).z);
    assert_eq!(scaled(", scale = 1"), Ok(2000.0));
    assert!((scaled(", scale = 0.001").unwrap() - 0.002).abs() < 1e-9);
    assert!((scaled(", scale = [0.001, 1, 1]").unwrap() - 2.0).abs() < 1e-9);
    assert!(scaled(", scale = \"mm\"").unwrap_err().contains("three numbers"));
}

#[test]
fn names_of_other_systems_are_understood() {
    let folder = Folder::new();
    folder.write("meshes/a floor.obj", format!("{QUAD}f 1 2 3 4\n").as_bytes());
    for name in [
        "meshes/a floor.obj",
        "meshes/a%20floor.obj",
        "meshes\\a floor.obj",
        "meshes\\a%20floor.obj",
    ] {
        assert!(load_as(&folder.path(""), name, "").is_ok(), "{name}");
    }
    folder.write("meshes/a%20floor.obj", format!("{QUAD}f 1 2 3\n").as_bytes());
    assert_eq!(load_as(&folder.path(""), "meshes/a%20floor.obj", "").unwrap().len(), 1);
}

/// A COLLADA file of one geometry, placed by `node`.
fn collada(positions: &str, params: &str, primitive: &str, node: &str) -> String {
    let (count, stride) =
        (positions.split_whitespace().count(), params.matches("<param").count().max(3));
    format!(
        "<COLLADA><asset><unit meter=\"1\"/></asset><library_geometries><geometry id=\"a b\"><mesh>\
         <source id=\"p\"><float_array id=\"n\" count=\"{count}\">{positions}</float_array><technique_common>\
         <accessor source=\"#n\" count=\"{}\" stride=\"{stride}\">{params}</accessor></technique_common></source>\
         <vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices>{primitive}</mesh></geometry></library_geometries>\
         <library_visual_scenes><visual_scene id=\"s\">{node}</visual_scene></library_visual_scenes>\
         <scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>",
        count / stride
    )
}

const SQUARE: &str = "0 0 0 1 0 0 1 1 0 0 1 0";
const INPUT: &str = "<input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/>";
const NODE: &str = "<node><instance_geometry url=\"#a%20b\"/></node>";

fn triangles_of(corners: &str) -> String {
    format!("<triangles count=\"1\">{INPUT}<p>{corners}</p></triangles>")
}

#[test]
fn collada_is_read_as_it_says() {
    let named = "<param name=\"X\"/><param name=\"Y\"/><param name=\"Z\"/>";
    let plain = collada(SQUARE, named, &triangles_of("0 1 2"), NODE);
    assert_eq!(area(&load("t.DAE", plain.as_bytes()).unwrap()), DVec3::Z * 0.5);
    // The accessor may name its numbers in another order and skip some.
    let order = "<param name=\"Z\"/><param/><param name=\"X\"/><param name=\"Y\"/>";
    let other = collada("0 9 0 0 0 9 1 0 0 9 1 1", order, &triangles_of("0 1 2"), NODE);
    assert_eq!(area(&load("t.dae", other.as_bytes()).unwrap()), DVec3::Z * 0.5);
    let colours = "<param name=\"R\"/><param name=\"G\"/><param name=\"B\"/>";
    refused("t.dae", collada(SQUARE, colours, &triangles_of("0 1 2"), NODE), &["X, Y and Z"]);
    let remarks = format!("\n<!-- -- --><?xml version=\"1.0\"?>{plain}");
    assert!(load("t.dae", remarks.as_bytes()).is_ok());
}

#[test]
fn a_collada_file_has_one_unit_and_names_its_scene() {
    let named = "<param name=\"X\"/><param name=\"Y\"/><param name=\"Z\"/>";
    let plain = collada(SQUARE, named, &triangles_of("0 1 2"), NODE);
    let own = |metres: &str| {
        let asset = format!("<geometry id=\"a b\"><asset><unit meter=\"{metres}\"/></asset>");
        plain.replace("<geometry id=\"a b\">", &asset)
    };
    assert_eq!(load("t.dae", own("1").as_bytes()), load("t.dae", plain.as_bytes()));
    refused("t.dae", own("0.01"), &["<geometry>", "<unit> of its own"]);
    let unnamed = plain.replace("<scene><instance_visual_scene url=\"#s\"/></scene>", "");
    assert_eq!(load("t.dae", unnamed.as_bytes()), load("t.dae", plain.as_bytes()));
    let empty = "<library_visual_scenes><visual_scene id=\"e\"/>";
    let several = unnamed.replace("<library_visual_scenes>", empty);
    refused("t.dae", several, &["several <visual_scene>s"]);
}

#[test]
fn concave_collada_faces_are_cut_as_they_are() {
    let positions = "0 0 0 4 0 0 4 2 0 2.2 2 0 2.2 .5 0 2 .5 0 2 2 0 0 2 0";
    for primitive in [
        format!("<polylist count=\"1\">{INPUT}<vcount>8</vcount><p>0 1 2 3 4 5 6 7</p></polylist>"),
        format!("<polygons count=\"1\">{INPUT}<p>6 7 0 1 2 3 4 5</p></polygons>"),
    ] {
        let triangles = load("t.dae", collada(positions, "", &primitive, NODE).as_bytes()).unwrap();
        let whole: f64 = triangles.iter().map(|of| area(&[*of]).length()).sum();
        assert!((whole - 7.7).abs() < 1e-12, "{whole}: {primitive}");
    }
    let line = format!("<polylist count=\"1\">{INPUT}<vcount>2</vcount><p>0 1</p></polylist>");
    refused("t.dae", collada(positions, "", &line, NODE), &["face of 2 corners"]);
}

#[test]
fn what_holds_no_surface_may_stand_in_a_collada_file() {
    let eye = "<node><lookat>5 5 3 0 0 0 0 0 1</lookat><instance_camera url=\"#c\"/></node>\
               <node><skew>1 0 0 0 0 1 0</skew><instance_light url=\"#l\"/></node>";
    let lines =
        format!("{}<lines count=\"1\">{INPUT}<p>0 1</p></lines><extra/>", triangles_of("0 1 2"));
    let text = collada(SQUARE, "", &lines, &format!("{eye}{NODE}"));
    assert_eq!(load("t.dae", text.as_bytes()).unwrap().len(), 1);
    for (node, part) in [
        (NODE.replace("<node>", "<node><lookat>5 5 3 0 0 0 0 0 1</lookat>"), "<lookat>"),
        (format!("<node><lookat>5 5 3 0 0 0 0 0 1</lookat>{NODE}</node>"), "<lookat>"),
        (format!("<node><instance_physics/></node>{NODE}"), "<instance_physics>"),
    ] {
        refused("t.dae", collada(SQUARE, "", &lines, &node), &[part]);
    }
    let patch = format!("{lines}<patches/>");
    refused("t.dae", collada(SQUARE, "", &patch, NODE), &["<patches>"]);
}

/// A file cut at any byte is refused or gives the whole mesh. OBJ has neither counts nor an end, so
/// that a cut can be seen within a face only: the rest is then the first of its faces.
#[test]
fn cut_files_are_refused_or_whole() {
    let folder = Folder::new();
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    let two = format!("solid x\n{FACET}{}endsolid x\n", FACET.replace(" 0\n", " 2\n"));
    let dae = collada(SQUARE, "", &triangles_of("0 1 2"), NODE);
    for (name, bytes) in [
        ("t.stl", binary_stl(b"cut me", 3, 3)),
        ("u.stl", two.into_bytes()),
        ("t.dae", dae.into_bytes()),
        ("t.obj", obj.as_bytes().to_vec()),
    ] {
        folder.write(name, &bytes);
        let whole = load_as(&folder.path(""), name, "").unwrap();
        for cut in 0..bytes.len() {
            folder.write(name, &bytes[..cut]);
            let Ok(found) = load_as(&folder.path(""), name, "") else { continue };
            let is_beginning = name == "t.obj" && whole.starts_with(&found);
            assert!(found == whole || is_beginning, "{name} cut at {cut}: {found:?}");
        }
    }
}
