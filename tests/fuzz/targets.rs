//! The readers: each with small good files, and words of its format.

use lucarne::{Error, Result, Warnings};
use std::fmt::Debug;
use std::fs;
use std::path::{Path, PathBuf};

/// How a reader is called; it returns what it found, in words.
#[derive(Clone, Copy)]
pub enum Reader {
    Bytes(fn(&[u8]) -> String),
    File(fn(&Path) -> String),
}

/// A reader to be tried.
pub struct Target {
    pub name: &'static str,
    /// Name of the file that it is given.
    pub file: &'static str,
    pub reader: Reader,
    pub seeds: fn() -> Vec<Vec<u8>>,
    /// Whether the seeds are read without an error.
    pub good: bool,
    /// Words of the format.
    pub words: &'static [&'static str],
    /// Puts files there that the seeds name.
    pub beside: fn(&Path),
}

const PLAIN: Target =
    Target { name: "", file: "input", reader: Reader::Bytes(|_| String::new()), seeds: Vec::new, good: true, words: &[], beside: |_| {} };

/// All readers.
pub fn all() -> Vec<Target> {
    vec![
        Target { name: "scene", file: "input.rad", reader: Reader::File(scene), seeds: scenes, words: RADIANCE, beside: parts, ..PLAIN },
        Target {
            name: "window",
            file: "input.rad",
            reader: Reader::File(window),
            seeds: || vec![kept("scenes/asymmetric/window.rad")],
            words: RADIANCE,
            ..PLAIN
        },
        Target {
            name: "materials",
            file: "input.rad",
            reader: Reader::File(scene),
            seeds: materials,
            good: false,
            words: RADIANCE,
            beside: parts,
        },
        Target {
            name: "gltf",
            file: "input.gltf",
            reader: Reader::File(scene),
            seeds: || vec![GLTF.into(), GLTF_NESTED.into()],
            words: GLTF_WORDS,
            ..PLAIN
        },
        Target { name: "glb", file: "input.glb", reader: Reader::File(scene), seeds: || vec![glb()], words: GLTF_WORDS, ..PLAIN },
        Target {
            name: "obj",
            file: "input.obj",
            reader: Reader::File(scene),
            seeds: || vec![OBJ.into()],
            words: OBJ_WORDS,
            beside: mtl,
            ..PLAIN
        },
        Target {
            name: "mtl",
            file: "input.mtl",
            reader: Reader::File(with_mtl),
            seeds: || vec![MTL.into()],
            words: OBJ_WORDS,
            beside: obj,
            ..PLAIN
        },
        Target {
            name: "honeybee",
            file: "input.hbjson",
            reader: Reader::File(honeybee),
            seeds: || vec![HONEYBEE.into()],
            words: HONEYBEE_WORDS,
            ..PLAIN
        },
        Target {
            name: "scene-info",
            file: "input.rad",
            reader: Reader::File(info),
            seeds: scenes,
            words: RADIANCE,
            beside: parts,
            ..PLAIN
        },
        Target { name: "weather", reader: Reader::Bytes(weather), seeds: || vec![wea(), epw(1), epw(4)], words: WEATHER_WORDS, ..PLAIN },
        Target {
            name: "points",
            reader: Reader::Bytes(|b| told(lucarne::scene::points::parse_points(b))),
            seeds: || vec![kept("scenes/asymmetric/points.txt"), b"0,0,.8,0,0,1\n1;2;3;0;0;-1\n".to_vec()],
            ..PLAIN
        },
        Target { name: "view", file: "input.vf", reader: Reader::File(view), seeds: views, words: VIEW_WORDS, ..PLAIN },
        Target {
            name: "klems",
            reader: Reader::Bytes(bsdf),
            seeds: || vec![kept("scenes/asymmetric/louvre.xml"), KLEMS_BLOCK.into()],
            words: BSDF_WORDS,
            ..PLAIN
        },
        Target { name: "tensor-tree", reader: Reader::Bytes(bsdf), seeds: trees, words: BSDF_WORDS, ..PLAIN },
        Target {
            name: "iea21",
            file: "input.txt",
            reader: Reader::File(|p| told(lucarne::bsdf::iea21::read(p))),
            seeds: || vec![iea21()],
            words: &["#phi_1:", "#theta_1:", "#Isym =", "#material:", "END", "°"],
            good: false,
            ..PLAIN
        },
        Target {
            name: "angular-table",
            reader: Reader::Bytes(table),
            seeds: || vec![kept("scenes/bsdf/film.dat"), b"angle Ts Td Rs Rd\n0 .5 .1 .1 .1\n90 0 0 1 0\n".to_vec()],
            words: &["Ts", "Td", "Rs", "Rd", "theta"],
            ..PLAIN
        },
        Target {
            name: "glass",
            file: "input.dat",
            reader: Reader::File(glass),
            seeds: || vec![kept("scenes/bsdf/clear_float.dat"), GLASS.into()],
            words: &["{ Thickness }", "{ Units, Wavelength Units }", "SI Microns", "Emissivity"],
            ..PLAIN
        },
        Target {
            name: "glass-json",
            file: "input.json",
            reader: Reader::File(glass),
            seeds: || vec![GLASS_JSON.into()],
            words: &["\"wavelength\"", "\"T\"", "\"spectral_data\"", "null"],
            good: false,
            ..PLAIN
        },
        Target {
            name: "layers",
            reader: Reader::Bytes(layers),
            seeds: || vec![b"glass:clear_6mm gap=16mm glass:tvis=.7,rvis=.1,tsol=.4,rsol=.3,coated".to_vec()],
            words: LAYER_WORDS,
            ..PLAIN
        },
        Target { name: "matrix", reader: Reader::Bytes(matrix), seeds: matrices, words: MATRIX_WORDS, ..PLAIN },
        Target { name: "matrix-rows", file: "input.mtx", reader: Reader::File(rows), seeds: matrices, words: MATRIX_WORDS, ..PLAIN },
        Target { name: "hdr", reader: Reader::Bytes(hdr), seeds: pictures, words: MATRIX_WORDS, ..PLAIN },
        Target {
            name: "exr",
            file: "input.exr",
            reader: Reader::File(exr),
            seeds: exrs,
            words: &["compression", "chlist", "channels", "dataWindow", "box2i", "tiles", "R", "Y"],
            ..PLAIN
        },
        Target {
            name: "pattern",
            reader: Reader::Bytes(pattern),
            seeds: || vec![b"v%03d.hdr".to_vec(), b"a/%d%%.hdr".to_vec()],
            words: &["%", "%03d", "%d", "%s", "%n", "%99999999999d"],
            ..PLAIN
        },
        Target {
            name: "project",
            file: "input.toml",
            reader: Reader::File(project),
            seeds: projects,
            words: PROJECT_WORDS,
            beside: room,
            ..PLAIN
        },
        Target {
            name: "plan",
            file: "input.toml",
            reader: Reader::File(plan),
            seeds: projects,
            words: PROJECT_WORDS,
            beside: room,
            ..PLAIN
        },
        Target {
            name: "suns",
            file: "C_eye.suns",
            reader: Reader::File(suns),
            seeds: || vec![kept("tests/fuzz/corpus/eye.suns")],
            ..PLAIN
        },
        Target {
            name: "summary",
            file: "summary.json",
            reader: Reader::File(|p| year(folder(p))),
            beside: stored,
            seeds: || vec![kept("tests/fuzz/corpus/summary.json")],
            words: &["null", "\"sensors\"", "\"windows\"", "\"views\"", "\"hours\""],
            ..PLAIN
        },
        Target {
            name: "illuminance",
            file: "illuminance/room.csv",
            reader: Reader::File(|p| year(folder(folder(p)))),
            seeds: || vec![kept("tests/fuzz/corpus/room.csv")],
            beside: stored,
            ..PLAIN
        },
        Target {
            name: "annual-glare",
            file: "glare/eye.csv",
            reader: Reader::File(|p| year(folder(folder(p)))),
            seeds: || vec![kept("tests/fuzz/corpus/glare.csv")],
            beside: stored,
            ..PLAIN
        },
    ]
}

fn told<T: Debug>(found: Result<T>) -> String {
    match found {
        Ok(_) => "read".into(),
        Err(e) => e.message().to_string(),
    }
}

fn with_warnings<T: Debug>(read: impl FnOnce(&mut Warnings) -> Result<T>) -> String {
    let mut warnings = Warnings::new();
    let answer = told(read(&mut warnings));
    let kinds: Vec<&str> = warnings.iter().map(Error::message).collect();
    format!("{answer} {}", kinds.join(" "))
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn kept(path: &str) -> Vec<u8> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn folder(path: &Path) -> &Path {
    path.parent().unwrap()
}

fn scene(path: &Path) -> String {
    with_warnings(|w| lucarne::scene::read_scene(&[path.to_path_buf()], folder(path), w))
}

fn window(path: &Path) -> String {
    with_warnings(|w| lucarne::scene::read_windows(path, folder(path), w))
}

fn with_mtl(path: &Path) -> String {
    scene(&folder(path).join("of_mtl.obj"))
}

fn honeybee(path: &Path) -> String {
    with_warnings(|w| lucarne::scene::honeybee::read(path, w).map(|m| m.windows.len()))
}

fn info(path: &Path) -> String {
    with_warnings(|w| lucarne::scene::info::SceneInfo::read(&[path.to_path_buf()], w))
}

fn weather(bytes: &[u8]) -> String {
    with_warnings(|w| lucarne::weather::Weather::from_bytes(bytes, w))
}

fn view(path: &Path) -> String {
    let view = lucarne::camera::View::read(path);
    // What is read must be usable: a camera, and solid angles that are numbers.
    let raster = view.clone().and_then(|v| v.camera()).and_then(|camera| lucarne::camera::Raster::new(camera, 7, 5));
    if let Ok(raster) = raster
        && let Ok(geometry) = lucarne::glare::PixelGeometry::new(&raster)
    {
        assert!(geometry.hemisphere_coverage().is_finite(), "solid angles are no numbers");
    }
    told(view)
}

fn bsdf(bytes: &[u8]) -> String {
    with_warnings(|w| lucarne::bsdf::read_from(bytes, w).map(|b| b.name.len()))
}

fn table(bytes: &[u8]) -> String {
    with_warnings(|w| lucarne::bsdf::isotropic::AngularTable::parse(&text(bytes), w))
}

fn glass(path: &Path) -> String {
    told(lucarne::bsdf::glass::Pane::parse_in(folder(path), path.file_name().unwrap().to_str().unwrap()))
}

fn layers(bytes: &[u8]) -> String {
    let text = text(bytes);
    // No files of this machine.
    let words: Vec<String> = text.split_whitespace().filter(|w| !w.contains('/')).map(str::to_string).collect();
    with_warnings(|w| lucarne::bsdf::layer::read_layers(&words, Path::new("/nowhere"), w).map(|l| l.layers.len()))
}

fn matrix(bytes: &[u8]) -> String {
    told(lucarne::matrix::file::read_matrix_from::<f32>(bytes))
}

fn rows(path: &Path) -> String {
    told(lucarne::matrix::rows::MatrixRows::open(path).and_then(|rows| {
        let mut values = Vec::new();
        let Some(mut rows) = rows else { return Ok(0) };
        while rows.read(16, &mut values)? > 0 {}
        Ok(rows.rows())
    }))
}

fn hdr(bytes: &[u8]) -> String {
    told(lucarne::image::hdr::decode(bytes, lucarne::image::hdr::Exposure::Undo).map(|p| p.width))
}

fn exr(path: &Path) -> String {
    told(lucarne::image::exr::parts(path).and_then(|_| lucarne::image::read(path)).map(|p| p.width))
}

fn pattern(bytes: &[u8]) -> String {
    told(lucarne::image::series::Pattern::parse(&text(bytes)).map(|p| p.path(7)))
}

fn project(path: &Path) -> String {
    told(lucarne::simulate::Project::read(path).map(|p| p.views.len()))
}

fn plan(path: &Path) -> String {
    let project = match lucarne::simulate::Project::read(path) {
        Ok(project) => project,
        Err(e) => return e.message().to_string(),
    };
    with_warnings(|w| lucarne::simulate::Plan::new(project, w).and_then(|plan| plan.outline()).map(|o| o.hours))
}

/// The checksum is made right first: else nothing would get beyond it.
fn suns(path: &Path) -> String {
    let mut bytes = fs::read(path).unwrap();
    const KEY: &[u8] = b"LUCARNE_CHECKSUM=";
    if let Some(at) = bytes.windows(KEY.len()).position(|w| w == KEY).map(|at| at + KEY.len())
        && bytes.len() >= at + 64
    {
        bytes[at..at + 64].fill(b'0');
        let digest = blake3::hash(&bytes).to_hex();
        bytes[at..at + 64].copy_from_slice(digest.as_bytes());
        fs::write(path, bytes).unwrap();
    }
    told(lucarne::simulate::SunPictures::open(path).and_then(|kept| {
        let mut lit = 0;
        let suns: Vec<usize> = kept.pictures.suns().take(50).collect();
        for sun in suns {
            lit += kept.pictures.of_sun(sun, 1.0)?.len();
        }
        Ok(lit)
    }))
}

fn year(folder: &Path) -> String {
    told(lucarne::simulate::Year::open(folder).map(|year| year.times.len()))
}

fn stored(folder: &Path) {
    for (file, corpus) in [
        ("summary.json", "summary.json"),
        ("illuminance/room.mtx", "room.mtx"),
        ("illuminance/room_standard_error.mtx", "room_standard_error.mtx"),
        ("illuminance/room.csv", "room.csv"),
        ("glare/eye.csv", "glare.csv"),
    ] {
        fs::create_dir_all(folder.join(file).parent().unwrap()).unwrap();
        fs::write(folder.join(file), kept(&format!("tests/fuzz/corpus/{corpus}"))).unwrap();
    }
}

const RADIANCE: &[&str] = &[
    "plastic",
    "metal",
    "trans",
    "glass",
    "glow",
    "light",
    "mirror",
    "dielectric",
    "interface",
    "BSDF",
    "aBSDF",
    "mixfunc",
    "mixpict",
    "colorpict",
    "brightfunc",
    "colorfunc",
    "texfunc",
    "BRTDfunc",
    "WGMDfunc",
    "spectrum",
    "alias",
    "inherit",
    "polygon",
    "sphere",
    "ring",
    "cylinder",
    "tube",
    "cup",
    "cone",
    "bubble",
    "source",
    "mesh",
    "instance",
    "antimatter",
    "spotlight",
    "prism1",
    "void",
    "!xform -n a -a 3 -t 1 0 0 part.rad",
    "!genbox m b 1 2 3",
    "!gensurf m s x y 0 3 3",
    "!genrev m r t t 8",
    "!genworm m w t t t 1 4",
    "!genprism m p 3 0 0 1 0 0 1 -l 0 0 1",
    "!genblinds m b .1 3 2 20 30",
    "-rx 30",
    "-s 2",
    "-mx",
    "-i 4",
    "-a 4",
    "cos(t)",
    "0\n0\n",
    "9\n0 0 0 1 0 0 0 1 0\n",
];

fn scenes() -> Vec<Vec<u8>> {
    let commands = "void plastic m\n0\n0\n5 .5 .5 .5 0 0\n!genbox m box 1 2 3 -b .1 | xform -t 1 0 0 -a 3 -t 2 0 0\n\
        !xform -n a -rz 30 part.rad\n!gensurf m s 's' 't' 's*t' 3 3 -s\n!genblinds m b .1 3 2 9 30\n!genrev m r 't' '1+t' 5\n\
        !genworm m w 't' '0' 't*t' '.1' 4\n!genprism m p 3 0 0 1 0 0 1 -l 0 0 1\nm sphere ball\n0\n0\n4 1 1 1 .5\nm ring r\n0\n0\n8 0 0 1 0 0 1 .1 .5\n\
        m cylinder c\n0\n0\n7 0 0 0 0 0 1 .2\nm cone k\n0\n0\n8 0 0 0 0 0 1 .2 .1\nvoid alias q m\nq source sun\n0\n0\n4 0 0 1 .5\n";
    vec![kept("scenes/asymmetric/room.rad"), commands.into()]
}

fn materials() -> Vec<Vec<u8>> {
    let square = "0\n0\n12 0 0 0 1 0 0 1 1 0 0 1 0\n";
    let text = format!(
        "void colorpict pic\n7 red green blue pattern.hdr . frac(Px) frac(Py)\n0\n0\npic plastic a\n0\n0\n5 .5 .5 .5 .1 .05\na polygon p1\n{square}\
         void mixfunc mix\n4 a void .5 .\n0\n0\nmix polygon p2\n{square}void trans t\n0\n0\n7 .5 .5 .5 0 0 .5 .2\nt polygon p3\n{square}\
         void glass g\n0\n0\n4 .9 .9 .9 1.5\ng polygon p4\n{square}void BRTDfunc b\n10 .1 .1 .1 .6 .6 .6 0 0 0 .\n0\n9 .1 .1 .1 .1 .1 .1 0 0 0\nb polygon p5\n{square}\
         void spectrum s\n0\n0\n5 380 780 .2 .4 .6\ns plastic c\n0\n0\n5 1 1 1 0 0\nc polygon p6\n{square}void brightfunc f\n4 if(Px,1,.5) . -rx 3\n0\n0\n\
         f metal d\n0\n0\n5 .9 .9 .9 .9 .1\nd polygon p7\n{square}void dielectric e\n0\n0\n5 .9 .9 .9 1.5 0\ne polygon p8\n{square}\
         void illum i\n1 a\n0\n3 1 1 1\ni polygon p9\n{square}void ashik2 h\n4 1 0 0 .\n0\n8 .2 .2 .2 .04 .04 .04 100 200\nh polygon p10\n{square}"
    );
    let each = |kind: &str, rest: &str| format!("void {kind} m\n{rest}\nm polygon p\n{square}").into_bytes();
    vec![
        text.into_bytes(),
        each("plastic2", "4 1 0 0 .\n0\n6 .5 .5 .5 .1 .1 .2"),
        each("interface", "0\n0\n8 .9 .9 .9 1.5 .9 .9 .9 1"),
        each("WGMDfunc", "13 void 1 .1 void 1 .1 void 0 0 1 0 0 .\n0\n9 .5 .5 .5 .5 .5 .5 0 0 0"),
        each("transdata", "4 noop t.dat . rz\n0\n6 .5 .5 .5 .1 .2 .3"),
        each("specpict", "5 noop p.hsr . u v\n0\n0"),
    ]
}

fn parts(folder: &Path) {
    fs::write(folder.join("part.rad"), "void plastic m\n0\n0\n5 .5 .5 .5 0 0\nm polygon p\n0\n0\n9 0 0 0 1 0 0 0 1 0\n").unwrap();
    fs::write(folder.join("pattern.hdr"), &pictures()[0]).unwrap();
}

const GLTF_WORDS: &[&str] = &[
    "\"nodes\"",
    "\"meshes\"",
    "\"accessors\"",
    "\"bufferViews\"",
    "\"buffers\"",
    "\"children\"",
    "\"matrix\"",
    "\"POSITION\"",
    "\"indices\"",
    "\"byteOffset\"",
    "\"byteStride\"",
    "\"componentType\"",
    "5126",
    "5125",
    "5123",
    "5121",
    "\"VEC3\"",
    "\"SCALAR\"",
    "\"mode\"",
    "\"sparse\"",
    "\"extensions\"",
    "\"EXT_mesh_gpu_instancing\"",
    "\"KHR_materials_transmission\"",
    "\"data:application/octet-stream;base64,AAAA\"",
    "\"extras\"",
];

const GLTF: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"name":"a","children":[1],"translation":[1,2,3]},{"mesh":0,"rotation":[0,0,0,1]}],
"materials":[{"name":"m","pbrMetallicRoughness":{"baseColorFactor":[0.5,0.4,0.3,1],"metallicFactor":0,"roughnessFactor":1},"extensions":{"KHR_materials_transmission":{"transmissionFactor":0.5}}}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"material":0}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},{"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}],
"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":6}],
"buffers":[{"byteLength":44,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAABAAIAAAA="}]}"#;

const GLTF_NESTED: &str = r#"{"asset":{"version":"2.0"},"extensionsUsed":["EXT_mesh_gpu_instancing"],"scene":0,"scenes":[{"nodes":[0,1]}],
"nodes":[{"children":[2,3]},{"mesh":0,"scale":[1,2,1],"extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":0}}}},{"mesh":0},{"mesh":0,"extras":{"lucarne":"window"}}],
"materials":[{"pbrMetallicRoughness":{"metallicFactor":1,"roughnessFactor":0}}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0],"sparse":{"count":1,"indices":{"bufferView":1,"componentType":5123},"values":{"bufferView":0}}}],
"bufferViews":[{"buffer":0,"byteLength":36,"byteStride":12},{"buffer":0,"byteOffset":36,"byteLength":6}],
"buffers":[{"byteLength":44,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAABAAIAAAA="}]}"#;

fn glb() -> Vec<u8> {
    let json =
        GLTF.replace(r#","uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAABAAIAAAA=""#, "");
    let json = format!("{json}{}", " ".repeat((4 - json.len() % 4) % 4));
    let mut data = Vec::new();
    for v in [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
        data.extend(v.to_le_bytes());
    }
    data.extend([0, 0, 1, 0, 2, 0, 0, 0]);
    let mut file = b"glTF\x02\0\0\0".to_vec();
    file.extend(((12 + 8 + json.len() + 8 + data.len()) as u32).to_le_bytes());
    file.extend((json.len() as u32).to_le_bytes());
    file.extend(b"JSON");
    file.extend(json.bytes());
    file.extend((data.len() as u32).to_le_bytes());
    file.extend(b"BIN\0");
    file.extend(data);
    file
}

const OBJ_WORDS: &[&str] = &[
    "v 0 0 0",
    "f 1 2 3",
    "f -1 -2 -3",
    "f 1/1/1 2//2 3",
    "g part",
    "o thing",
    "usemtl m",
    "mtllib input.mtl",
    "vn 0 0 1",
    "Kd",
    "Ks",
    "Ns",
    "d",
    "Tr",
    "illum 3",
    "newmtl",
];
const OBJ: &str = "mtllib of_obj.mtl\no room\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv .5 .5 1\nvn 0 0 1\nvt 0 0\ng floor\nusemtl white\nf 1 2 3 4\nusemtl glass\nf 1/1/1 2/1/1 5/1/1\nf -1//1 -2//1 -3//1\n";
const MTL: &str = "newmtl white\nKd .8 .8 .8\nKs 0 0 0\nNs 10\nillum 2\nnewmtl glass\nKd .1 .1 .1\nd .3\nTf .7 .7 .7\nNi 1.5\n";

fn mtl(folder: &Path) {
    fs::write(folder.join("of_obj.mtl"), MTL).unwrap();
}

fn obj(folder: &Path) {
    fs::write(folder.join("of_mtl.obj"), OBJ.replace("of_obj.mtl", "input.mtl")).unwrap();
}

const HONEYBEE_WORDS: &[&str] = &[
    "\"boundary\"",
    "\"holes\"",
    "\"Face3D\"",
    "\"Plane\"",
    "\"type\"",
    "\"Glass\"",
    "\"Plastic\"",
    "\"BSDF\"",
    "\"mesh\"",
    "\"identifier\"",
    "\"Outdoors\"",
    "\"AirBoundary\"",
    "\"vertices\"",
    "\"units\"",
    "\"Feet\"",
    "[0,0,0]",
];
const HONEYBEE: &str = r#"{"type":"Model","identifier":"m","units":"Meters","version":"1.57.0","properties":{"type":"ModelProperties","radiance":{"type":"ModelRadianceProperties","modifier_sets":[],
"modifiers":[{"type":"Plastic","identifier":"white","r_reflectance":0.7,"g_reflectance":0.7,"b_reflectance":0.7,"specularity":0,"roughness":0},{"type":"Glass","identifier":"clear","r_transmissivity":0.9,"g_transmissivity":0.9,"b_transmissivity":0.9}],
"sensor_grids":[{"type":"SensorGrid","identifier":"grid","sensors":[{"type":"Sensor","pos":[1,1,0.8],"dir":[0,0,1]}]}],"views":[{"type":"View","identifier":"v","position":[1,1,1],"direction":[0,1,0],"up_vector":[0,0,1],"view_type":"h","h_size":180,"v_size":180}]}},
"rooms":[{"type":"Room","identifier":"r","faces":[{"type":"Face","identifier":"floor","face_type":"Floor","boundary_condition":{"type":"Ground"},"geometry":{"type":"Face3D","boundary":[[0,0,0],[0,3,0],[3,3,0],[3,0,0]]},"properties":{"type":"FacePropertiesAbridged","radiance":{"type":"FaceRadiancePropertiesAbridged","modifier":"white"}}},
{"type":"Face","identifier":"south","face_type":"Wall","boundary_condition":{"type":"Outdoors"},"geometry":{"type":"Face3D","boundary":[[0,0,0],[3,0,0],[3,0,3],[0,0,3]]},"properties":{"type":"FacePropertiesAbridged","radiance":{"type":"FaceRadiancePropertiesAbridged"}},
"apertures":[{"type":"Aperture","identifier":"pane","boundary_condition":{"type":"Outdoors"},"geometry":{"type":"Face3D","boundary":[[1,0,1],[2,0,1],[2,0,2],[1,0,2]]},"properties":{"type":"AperturePropertiesAbridged","radiance":{"type":"ApertureRadiancePropertiesAbridged","modifier":"clear"}}}]}],"properties":{"type":"RoomPropertiesAbridged"}}],
"orphaned_shades":[{"type":"Shade","identifier":"s","geometry":{"type":"Face3D","boundary":[[0,-1,3],[3,-1,3],[3,0,3],[0,0,3]],"holes":[[[1,-0.5,3],[2,-0.5,3],[2,-0.2,3]]]},"properties":{"type":"ShadePropertiesAbridged"}}]}"#;

const WEATHER_WORDS: &[&str] = &[
    "LOCATION",
    "DATA PERIODS",
    "place",
    "latitude",
    "longitude",
    "time_zone",
    "site_elevation",
    "weather_data_file_units",
    "1 1 0.5 0 0",
    "9999",
    "-999",
    "2/29",
    "24",
];

fn wea() -> Vec<u8> {
    let mut text =
        "place Test_USA\nlatitude 40.78\nlongitude 73.96\ntime_zone 75\nsite_elevation 40.0\nweather_data_file_units 1\n".to_string();
    (0..24).for_each(|hour| text.push_str(&format!("3 21 {hour}.500 {} {}\n", (hour / 8 % 2) * 500, (hour / 8 % 2) * 150)));
    text.into_bytes()
}

fn epw(per_hour: usize) -> Vec<u8> {
    let mut text = format!(
        "LOCATION,Test,-,USA,TMY3,725033,40.78,-73.97,-5.0,40.0\nDESIGN CONDITIONS,0\nTYPICAL/EXTREME PERIODS,0\nGROUND TEMPERATURES,0\n\
         HOLIDAYS/DAYLIGHT SAVINGS,No,0,0,0\nCOMMENTS 1,x\nCOMMENTS 2,x\nDATA PERIODS,1,{per_hour},Data,Sunday, 1/ 1, 1/ 1\n"
    );
    for hour in 0..24 {
        for part in 1..=per_hour {
            let sun = if (8..16).contains(&hour) { 400 } else { 0 };
            text.push_str(&format!(
                "1999,1,1,{},{},A7,5.0,-1.0,60,101000,0,0,300,{sun},{sun},{},9999,9999,9999,9999,180,3.0,5,5,16.0,77777,9,999999999,0,0.1,0,88,0.2,0,0\n",
                hour + 1,
                60 * part / per_hour,
                sun / 2
            ));
        }
    }
    text.into_bytes()
}

const VIEW_WORDS: &[&str] =
    &["-vtv", "-vth", "-vta", "-vtl", "-vtc", "-vts", "-vp", "-vd", "-vu", "-vh", "-vv", "-vo", "-va", "-vs", "-vl", "VIEW=", "rvu"];

fn views() -> Vec<Vec<u8>> {
    [
        "rvu -vta -vp 1.2 1.6 1.2 -vd 0 -1 0 -vu 0 0 1 -vh 180 -vv 180\n",
        "VIEW= -vtv -vp 0 0 0 -vd 1 0 0 -vu 0 0 1 -vh 45 -vv 45 -vs 0 -vl 0 -vo 0 -va 0\n",
        "-vtl -vp 0 0 0 -vd 0 0 -1 -vu 0 1 0 -vh 3 -vv 3\n",
    ]
    .map(|s| s.as_bytes().to_vec())
    .to_vec()
}

const BSDF_WORDS: &[&str] = &[
    "<ScatteringData>",
    "</ScatteringData>",
    "<ScatteringDataType>",
    "Columns",
    "Rows",
    "TensorTree3",
    "TensorTree4",
    "LBNL/Klems Full",
    "LBNL/Klems Half",
    "LBNL/Klems Quarter",
    "LBNL/Shirley-Chiu",
    "Transmission Front",
    "Transmission Back",
    "Reflection Front",
    "Visible",
    "Solar",
    "CIE-X",
    "BTDF",
    "<WavelengthData>",
    "</WavelengthData>",
    "<Theta>",
    "<nPhis>",
    "<Geometry format=\"MGF\">",
    "{ 0.3 }",
    "{{{",
    "}}}",
];

const KLEMS_BLOCK: &str = r#"<?xml version="1.0"?><WindowElement><Optical><Layer><Material><Name>n</Name><Manufacturer>m</Manufacturer><Thickness unit="Meter">0.01</Thickness></Material>
<DataDefinition><IncidentDataStructure>Columns</IncidentDataStructure><AngleBasis><AngleBasisName>own</AngleBasisName>
<AngleBasisBlock><Theta>0</Theta><nPhis>1</nPhis><ThetaBounds><LowerTheta>0</LowerTheta><UpperTheta>30</UpperTheta></ThetaBounds></AngleBasisBlock>
<AngleBasisBlock><Theta>60</Theta><nPhis>2</nPhis><ThetaBounds><LowerTheta>30</LowerTheta><UpperTheta>90</UpperTheta></ThetaBounds></AngleBasisBlock></AngleBasis></DataDefinition>
<WavelengthData><LayerNumber>System</LayerNumber><Wavelength unit="Integral">Visible</Wavelength><WavelengthDataBlock><WavelengthDataDirection>Transmission Front</WavelengthDataDirection>
<ColumnAngleBasis>own</ColumnAngleBasis><RowAngleBasis>own</RowAngleBasis><ScatteringDataType>BTDF</ScatteringDataType><ScatteringData>.1,.2,.3,.1,.2,.3,.1,.2,.3</ScatteringData></WavelengthDataBlock></WavelengthData>
</Layer></Optical></WindowElement>"#;

fn trees() -> Vec<Vec<u8>> {
    let of = |rank: usize, tree: &str| {
        format!(
            r#"<?xml version="1.0"?><WindowElement><Optical><Layer><Material><Name>n</Name></Material><DataDefinition><IncidentDataStructure>TensorTree{rank}</IncidentDataStructure></DataDefinition>
<WavelengthData><LayerNumber>System</LayerNumber><Wavelength unit="Integral">Visible</Wavelength><WavelengthDataBlock><WavelengthDataDirection>Transmission Front</WavelengthDataDirection>
<AngleBasis>LBNL/Shirley-Chiu</AngleBasis><ScatteringDataType>BTDF</ScatteringDataType><ScatteringData>{tree}</ScatteringData></WavelengthDataBlock></WavelengthData></Layer></Optical></WindowElement>"#
        )
        .into_bytes()
    };
    let leaves = "{ .1 } ".repeat(8);
    let grid = ".1 .2 ".repeat(8);
    vec![of(4, "{ 0.3 }"), of(3, &format!("{{ {leaves} }}")), of(4, &format!("{{ {grid} }}"))]
}

fn iea21() -> Vec<u8> {
    let mut text = String::new();
    for theta in [0, 6, 18, 30, 42, 54, 66, 78, 90] {
        text.push_str(&format!("#material: test\n#Isym = 1\n#phi_1: 90\n#theta_1: {theta}\n"));
        for phi in (0..360).step_by(90) {
            [95, 120, 150].iter().for_each(|out| text.push_str(&format!("{phi} {out} 0.1\n")));
        }
        text.push_str("END\n");
    }
    text.into_bytes()
}

const GLASS: &str = "{ Units, Wavelength Units } SI Microns\n{ Thickness } 6\n{ Conductivity } 1\n{ IR Transmittance } TIR=0\n{ Emissivity, front back } Emis= 0.84 0.84\n{ }\n0.300 0.1 0.05 0.05\n0.500 0.9 0.08 0.08\n0.780 0.8 0.07 0.07\n2.500 0.5 0.05 0.05\n";
const GLASS_JSON: &str = r#"{"name":"n","thickness":6.0,"measurements":[{"spectral_data":{"angle_block":[{"spectral_data":[{"wavelength":0.3,"T":0.1,"Rf":0.05,"Rb":0.05},{"wavelength":2.5,"T":0.5,"Rf":0.05,"Rb":0.05}]}]}}],"spectral_data":[{"wavelength":0.38,"T":0.8,"Rf":0.1,"Rb":0.1},{"wavelength":0.78,"T":0.8,"Rf":0.1,"Rb":0.1}]}"#;
const LAYER_WORDS: &[&str] = &[
    "glass:clear_3mm",
    "gap=12mm",
    "flip:",
    "tvis=",
    "rvis=",
    "tsol=",
    "coated",
    "thickness=6mm",
    "rvis_back=",
    "glass:",
    "gap=",
    "km",
    "mm",
];

const MATRIX_WORDS: &[&str] = &[
    "NROWS=",
    "NCOLS=",
    "NCOMP=",
    "FORMAT=ascii",
    "FORMAT=float",
    "FORMAT=double",
    "#?RADIANCE\n",
    "\n\n",
    "BigEndian=1",
    "FORMAT=32-bit_rle_rgbe",
    "-Y 2 +X 3\n",
    "+X 2 -Y 3\n",
    "EXPOSURE=2",
    "VIEW= -vta",
    "\u{2}\u{2}",
];

fn matrices() -> Vec<Vec<u8>> {
    let header = |format: &str| format!("#?RADIANCE\nNROWS=2\nNCOLS=2\nNCOMP=3\nFORMAT={format}\n\n").into_bytes();
    let values: Vec<f32> = (0..12u8).map(f32::from).collect();
    let ascii = values.iter().map(|v| format!("{v} ")).collect::<String>();
    let mut float = header("float");
    values.iter().for_each(|v| float.extend(v.to_le_bytes()));
    let mut double = header("double");
    values.iter().for_each(|v| double.extend(f64::from(*v).to_le_bytes()));
    vec![[header("ascii"), ascii.into_bytes()].concat(), float, double]
}

fn pictures() -> Vec<Vec<u8>> {
    let head = |size: &str| format!("#?RADIANCE\nVIEW= -vtv -vh 45 -vv 45\nEXPOSURE=1.5\nFORMAT=32-bit_rle_rgbe\n\n{size}\n").into_bytes();
    let flat: Vec<u8> = (0..24u8).map(|i| 120 + i).collect();
    let mut coded = head("-Y 2 +X 8");
    for _ in 0..2 {
        coded.extend([2, 2, 0, 8]);
        (0..4u8).for_each(|c| coded.extend([128 + 5, 100 + c, 3, 1, 2, 3]));
    }
    let mut old = head("-Y 1 +X 4");
    old.extend([9, 9, 9, 128, 1, 1, 1, 3]);
    vec![coded, [head("-Y 2 +X 3"), flat].concat(), old]
}

fn exrs() -> Vec<Vec<u8>> {
    use lucarne::image::{Picture, exr};
    let folder = tempfile::tempdir().unwrap();
    let picture = Picture::new(5, 3, (0..15u8).map(|i| [f32::from(i), 1.0, 0.5]).collect()).unwrap();
    let of = |(number, samples, channels): (usize, exr::Samples, exr::Channels)| {
        let path = folder.path().join(format!("{number}.exr"));
        exr::write(&path, &picture, exr::Options { samples, channels }, &mut Warnings::new()).unwrap();
        fs::read(path).unwrap()
    };
    [(0, exr::Samples::Half, exr::Channels::Rgb), (1, exr::Samples::Float, exr::Channels::Luminance)].map(of).to_vec()
}

const PROJECT_WORDS: &[&str] = &[
    "[weather]",
    "[scene]",
    "[[window]]",
    "[[sensors]]",
    "[[view]]",
    "[images]",
    "[glare]",
    "[method]",
    "[quality]",
    "[output]",
    "[[moment]]",
    "file",
    "files",
    "surface",
    "bsdf",
    "glass",
    "glazing",
    "shade",
    "points",
    "spacing",
    "height",
    "resolution",
    "hours",
    "method",
    "phases",
    "sky_subdivision",
    "preset",
    "target_error",
    "time_limit",
    "seed",
    "memory",
    "name",
    "sky = \"cie overcast\"",
    "date",
    "site",
    "\"final\"",
    "\"draft\"",
    "[400, 400]",
    "north",
    "ground_albedo",
    "states",
    "\"../x\"",
    "grid",
    "model",
];

fn projects() -> Vec<Vec<u8>> {
    let glass = "[weather]\nsky = \"cie clear\"\ndate = \"03-21T12:00\"\nsite = [40.8, -74, -5]\n[scene]\nfiles = [\"room.rad\"]\n[[window]]\nname = \"w\"\nsurface = \"window.rad\"\nglass = 0.6\n[[sensors]]\nname = \"s\"\nsurface = \"floor\"\nspacing = 1\nheight = 0.8\n";
    let whole = "[weather]\nfile = \"day.wea\"\n[scene]\nfiles = [\"room.rad\"]\n[[window]]\nname = \"south\"\nsurface = \"window.rad\"\nbsdf = \"louvre.xml\"\n\
        [[sensors]]\nname = \"room\"\npoints = \"points.txt\"\n[[view]]\nname = \"eye\"\nfile = \"eye.vf\"\nresolution = [12, 12]\n[images]\nhours = [1909]\n\
        [glare]\nmethod = \"image\"\n[method]\nphases = 3\nsky_subdivision = 1\n[quality]\npreset = \"draft\"\nseed = 3\n";
    vec![whole.into(), glass.into()]
}

fn room(folder: &Path) {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/asymmetric");
    let files: Vec<PathBuf> = ["room.rad", "window.rad", "louvre.xml", "points.txt"].iter().map(|f| scenes.join(f)).collect();
    files.iter().for_each(|f| fs::copy(f, folder.join(f.file_name().unwrap())).map(|_| ()).unwrap());
    fs::write(folder.join("day.wea"), wea()).unwrap();
    fs::write(folder.join("eye.vf"), &views()[0]).unwrap();
}
