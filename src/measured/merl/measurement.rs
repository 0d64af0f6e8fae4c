//! The MERL format as a measurement.

use brdfit_brdf::Brdf;

use crate::brdf::MeasuredBrdf;
use crate::cells::Cells;
use crate::error::{MeasurementError, ValueFault};
use crate::grid::dimensions::Dimensions;
use crate::grid::sample_position::SamplePosition;
use crate::info::Info;
use crate::mapped_file::MappedFile;
use crate::measurement::{Described, Format, Measurement, Source, Survey};
use crate::merl::file::MerlFile;
use crate::merl::header;
use crate::merl::health::HealthChecks;
use crate::slices::Slices;

/// Matusik, Pfister, Brand & McMillan 2003: three planes of doubles over half and difference angles. The container does not say
/// where in its cell a sample lies: [`SamplePosition::default`] where the user does not, either.
pub(crate) static MERL: Format =
    Format { id: "merl", name: "MERL", extensions: &["binary"], probe: header::recognises, open };

#[derive(Debug)]
struct Merl {
    file: MerlFile,
    source: Source,
}

fn open(file: MappedFile, position: Option<SamplePosition>) -> Result<Box<dyn Measurement>, MeasurementError> {
    let file = MerlFile::of_mapped(file)?;
    let path = file.path().to_path_buf();
    Ok(Box::new(Merl { file, source: Source { path, format: MERL.id, sample_position: position.unwrap_or_default() } }))
}

impl Measurement for Merl {
    fn source(&self) -> &Source {
        &self.source
    }

    fn dimensions(&self) -> Dimensions {
        self.file.dimensions()
    }

    fn survey(&self, accept_non_finite: bool) -> Result<Survey, MeasurementError> {
        let scan = self.file.scan();
        match scan.fault() {
            None => {}
            Some(ValueFault::NotANumber { .. } | ValueFault::Infinite { .. })
                if accept_non_finite && scan.valid_cells() > 0 => {}
            Some(fault) => return Err(MeasurementError::new(&self.source.path, fault)),
        }
        Ok(Survey { sha256: scan.sha256_hex(), valid: scan.into_valid() })
    }

    fn slices(&self) -> Slices {
        self.file.slices(self.source.sample_position)
    }

    fn cells(&self) -> Option<Cells<'_>> {
        Some(self.file.cells())
    }

    fn brdf(&self) -> Result<Box<dyn Brdf>, MeasurementError> {
        Ok(Box::new(MeasuredBrdf::new(&self.file, self.source.sample_position)?))
    }

    fn info(&self, checks: &HealthChecks) -> Described {
        let scan = self.file.scan();
        let health = checks.of(self.file.dimensions(), self.source.sample_position).examine(&self.file, &scan);
        let fault = scan.fault().map(|fault| MeasurementError::new(&self.source.path, fault));
        Described { info: Info::Cells(Box::new(health)), fault }
    }
}
