//! Layout of JSON files: objects one member per line, lists of numbers on one line, which keeps files readable
//! and line-by-line differences meaningful.

use std::io::{self, Write};

use serde::Serialize;
use serde_json::ser::{Formatter, Serializer};

/// The bytes of a JSON file, with a final newline.
pub(crate) fn to_vec(value: &impl Serialize) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(1 << 15);
    let mut serializer = Serializer::with_formatter(&mut bytes, Layout::default());
    value.serialize(&mut serializer).expect("documents are made of numbers, texts, lists and named members");
    bytes.push(b'\n');
    bytes
}

/// A container that is being written.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Container {
    Object,
    /// A list, and whether it holds lists or objects, which go on lines of their own.
    List {
        nested: bool,
    },
}

/// The layout described above.
#[derive(Default)]
struct Layout {
    open: Vec<Container>,
    /// Whether the innermost container has a member.
    filled: bool,
}

impl Layout {
    fn new_line(&self, out: &mut (impl Write + ?Sized)) -> io::Result<()> {
        out.write_all(b"\n")?;
        self.open.iter().try_for_each(|_| out.write_all(b"  "))
    }

    fn enter(&mut self, out: &mut (impl Write + ?Sized), container: Container, bracket: &[u8]) -> io::Result<()> {
        if let Some(Container::List { nested }) = self.open.last_mut() {
            *nested = true;
            self.new_line(out)?;
        }
        self.open.push(container);
        self.filled = false;
        out.write_all(bracket)
    }

    fn leave(&mut self, out: &mut (impl Write + ?Sized), bracket: &[u8]) -> io::Result<()> {
        let spread = self.open.pop() != Some(Container::List { nested: false });
        if spread && self.filled {
            self.new_line(out)?;
        }
        self.filled = true;
        out.write_all(bracket)
    }
}

impl Formatter for Layout {
    fn begin_array<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.enter(out, Container::List { nested: false }, b"[")
    }

    fn end_array<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.leave(out, b"]")
    }

    fn begin_array_value<W: ?Sized + Write>(&mut self, out: &mut W, first: bool) -> io::Result<()> {
        match (first, self.open.last()) {
            (true, _) => Ok(()),
            (false, Some(Container::List { nested: true })) => out.write_all(b","),
            (false, _) => out.write_all(b", "),
        }
    }

    fn end_array_value<W: ?Sized + Write>(&mut self, _: &mut W) -> io::Result<()> {
        self.filled = true;
        Ok(())
    }

    fn begin_object<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.enter(out, Container::Object, b"{")
    }

    fn end_object<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.leave(out, b"}")
    }

    fn begin_object_key<W: ?Sized + Write>(&mut self, out: &mut W, first: bool) -> io::Result<()> {
        if !first {
            out.write_all(b",")?;
        }
        self.new_line(out)
    }

    fn begin_object_value<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        out.write_all(b": ")
    }

    fn end_object_value<W: ?Sized + Write>(&mut self, _: &mut W) -> io::Result<()> {
        self.filled = true;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    #[test]
    fn the_layout() {
        let value = json!({
            "a": [1, 2.5, null], "b": {}, "c": [], "d": [[1, 2], [3, 4]], "e": [{"x": 1}, {"x": []}], "f": "text"
        });
        let expected = r#"{
  "a": [1, 2.5, null],
  "b": {},
  "c": [],
  "d": [
    [1, 2],
    [3, 4]
  ],
  "e": [
    {
      "x": 1
    },
    {
      "x": []
    }
  ],
  "f": "text"
}
"#;
        let bytes = to_vec(&value);
        assert_eq!(String::from_utf8(bytes.clone()).unwrap(), expected);
        assert_eq!(serde_json::from_slice::<Value>(&bytes).unwrap(), value);
    }

    #[test]
    fn doubles_read_back_as_they_were() {
        let values = [0.1, 1e-300, 5e-324, f64::MAX, 1.0 / 3.0, 123_456_789.123_456_79];
        let back: [f64; 6] = serde_json::from_slice(&to_vec(&values)).unwrap();
        assert_eq!(back, values);
    }
}
