//! Messages, progress, tables, exit codes.

pub(crate) mod console;
pub(crate) mod diagnostics;
pub(crate) mod exit_code;
pub(crate) mod info_text;
pub(crate) mod library_errors;
pub(crate) mod table;
