//! As much of OpenEXR as the tests need, from the format's description ("OpenEXR File Layout") and without the program's library.

/// The first four bytes of a file, and version 2 without flags.
const HEAD: [u8; 8] = [0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0];
/// Samples of 32 bits.
const FLOAT: i32 = 2;

/// A file of one part without compression, channels B, G, R.
pub(crate) fn plain(width: usize, height: usize, pixels: impl Fn(usize, usize) -> [f32; 3]) -> Vec<u8> {
    let numbers = |values: &[i32]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
    let channel = |name: u8| [&[name, 0][..], &numbers(&[FLOAT]), &[0; 4], &numbers(&[1, 1])].concat();
    let channels = [channel(b'B'), channel(b'G'), channel(b'R'), vec![0]].concat();
    let window = numbers(&[0, 0, width as i32 - 1, height as i32 - 1]);
    let one = 1.0_f32.to_le_bytes().to_vec();
    let mut file = HEAD.to_vec();
    for (name, kind, value) in [
        ("channels", "chlist", channels),
        ("compression", "compression", vec![0]),
        ("dataWindow", "box2i", window.clone()),
        ("displayWindow", "box2i", window),
        ("lineOrder", "lineOrder", vec![0]),
        ("pixelAspectRatio", "float", one.clone()),
        ("screenWindowCenter", "v2f", vec![0; 8]),
        ("screenWindowWidth", "float", one),
    ] {
        for text in [name, kind] {
            file.extend(text.bytes());
            file.push(0);
        }
        file.extend(numbers(&[value.len() as i32]));
        file.extend(value);
    }
    file.push(0);
    let (start, line) = (file.len() + 8 * height, 8 + 12 * width);
    file.extend((0..height).flat_map(|y| ((start + y * line) as u64).to_le_bytes()));
    for y in 0..height {
        file.extend(numbers(&[y as i32, 12 * width as i32]));
        for c in [2, 1, 0] {
            file.extend((0..width).flat_map(|x| pixels(x, y)[c].to_le_bytes()));
        }
    }
    file
}

/// The names of the channels of the first part, in their order.
pub(crate) fn channels(file: &[u8]) -> Vec<String> {
    assert_eq!(file[..5], HEAD[..5], "no OpenEXR file of version 2");
    let text = |at: usize| {
        let end = at + file[at..].iter().position(|&byte| byte == 0).unwrap();
        (String::from_utf8(file[at..end].to_vec()).unwrap(), end + 1)
    };
    let mut at = HEAD.len();
    loop {
        let (name, kind) = text(at);
        let (_, size) = text(kind);
        let value = size + 4;
        if name == "channels" {
            let mut names = Vec::new();
            let mut at = value;
            while file[at] != 0 {
                let (name, end) = text(at);
                names.push(name);
                at = end + 16;
            }
            return names;
        }
        at = value + i32::from_le_bytes(file[size..value].try_into().unwrap()) as usize;
    }
}
