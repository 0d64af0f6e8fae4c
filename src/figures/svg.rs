//! The text of vector figures: escaping, indices, numbers and tick labels.

use crate::axis::Label;

/// Size of an index or exponent beside text of 12 or 13 pixels.
const INDEX_SIZE: f64 = 9.0;

/// Text of a document for an element or an attribute; characters that XML forbids are left out.
#[must_use]
pub fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\u{fffe}' | '\u{ffff}' => {}
            character if character.is_control() => {}
            character => escaped.push(character),
        }
    }
    escaped
}

/// A symbol with its index, and what follows in the same line of text. Sizes are absolute and the space is a shift:
/// not every viewer knows percentages, and some drop a leading space.
#[must_use]
pub fn indexed(symbol: &str, index: &str, rest: &str) -> String {
    let index = format!("{symbol}<tspan dy=\"3\" font-size=\"{INDEX_SIZE}\">{index}</tspan>");
    if rest.is_empty() { index } else { format!("{index}<tspan dx=\"4\" dy=\"-3\">{rest}</tspan>") }
}

/// The text of a tick.
#[must_use]
pub fn label(label: &Label) -> String {
    match label {
        Label::Plain(text) => escape(text),
        Label::PowerOfTen(0) => "1".to_owned(),
        Label::PowerOfTen(1) => "10".to_owned(),
        Label::PowerOfTen(exponent) => {
            let exponent = minus(&exponent.to_string());
            format!("10<tspan dy=\"-5\" font-size=\"{INDEX_SIZE}\">{exponent}</tspan>")
        }
    }
}

/// About how wide the text of a tick is. Text with an index or exponent starts at its anchor, as not every viewer can centre
/// or end it there.
#[must_use]
pub fn label_width(label: &Label) -> f64 {
    match label {
        Label::Plain(text) => 7.0 * text.chars().count() as f64,
        Label::PowerOfTen(0) => 7.0,
        Label::PowerOfTen(1) => 14.0,
        Label::PowerOfTen(exponent) => 14.0 + 5.5 * exponent.to_string().len() as f64,
    }
}

/// Three significant digits, short.
#[must_use]
pub fn number(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let scientific = format!("{value:.2e}");
    let exponent = scientific.split_once('e').and_then(|(_, exponent)| exponent.parse::<i32>().ok()).unwrap_or(0);
    match usize::try_from(2 - exponent) {
        Ok(decimals) if exponent >= -3 => minus(&format!("{value:.decimals$}")),
        Err(_) if exponent <= 5 => minus(&format!("{value:.0}")),
        _ => minus(&scientific),
    }
}

/// A minus sign instead of a hyphen.
fn minus(text: &str) -> String {
    text.replace('-', "\u{2212}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_cannot_break_the_document() {
        assert_eq!(escape("a<b>&\"c\"\u{0}\u{1b}[0m\u{ffff}é"), "a&lt;b&gt;&amp;&quot;c&quot;[0mé");
    }

    #[test]
    fn numbers_have_three_digits() {
        for (value, expected) in [
            (0.0, "0"),
            (0.123_456, "0.123"),
            (0.999_9, "1.00"),
            (12.345, "12.3"),
            (1234.5, "1234"),
            (0.001_234, "0.00123"),
            (-0.5, "\u{2212}0.500"),
            (1.234e-5, "1.23e\u{2212}5"),
            (1.234e7, "1.23e7"),
        ] {
            assert_eq!(number(value), expected, "{value}");
        }
    }
}
