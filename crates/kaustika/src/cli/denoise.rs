//! `kaustika denoise`.

use super::args::DenoiseArgs;
use super::failure::Failure;
use super::picture;
use kaustika::film::read_picture;

/// Takes the noise out of an image file.
///
/// # Errors
/// If the image can't be read, filtered or written.
pub fn run(args: &DenoiseArgs) -> Result<(), Failure> {
    picture::check_outputs(&args.output)?;
    args.filter.check().map_err(Failure::usage)?;
    let mut image = read_picture(&args.image).map_err(Failure::input)?;
    let report = args
        .filter
        .apply(&mut image)
        .map_err(|e| Failure::Input(format!("{}: {e}", args.image.display())))?;
    picture::write(&args.output, &image, &args.look)?;
    eprintln!("{report}");
    picture::tell(&args.output);
    Ok(())
}
