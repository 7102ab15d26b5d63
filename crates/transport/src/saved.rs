//! What learning methods write into checkpoints: numbers, lists and structures of them, little
//! endian, without names. The checkpoint around them says which program and method wrote it.

use kaustika_math::Vec3;
use std::io::{self, Read, Write};

/// Can be written and read back, bit for bit.
pub trait Saved: Sized {
    /// Writes it.
    ///
    /// # Errors
    /// As the writer's.
    fn save(&self, out: &mut dyn Write) -> io::Result<()>;

    /// Reads what [`Saved::save`] wrote.
    ///
    /// # Errors
    /// As the reader's, or if it does not fit.
    fn load(from: &mut dyn Read) -> io::Result<Self>;
}

macro_rules! numbers {
    ($($T:ty),*) => {$(
        impl Saved for $T {
            fn save(&self, out: &mut dyn Write) -> io::Result<()> {
                out.write_all(&self.to_le_bytes())
            }

            fn load(from: &mut dyn Read) -> io::Result<Self> {
                let mut bytes = [0; size_of::<$T>()];
                from.read_exact(&mut bytes)?;
                Ok(<$T>::from_le_bytes(bytes))
            }
        }
    )*};
}

numbers!(u8, u32, u64, f32, f64);

impl Saved for bool {
    fn save(&self, out: &mut dyn Write) -> io::Result<()> {
        u8::from(*self).save(out)
    }

    fn load(from: &mut dyn Read) -> io::Result<Self> {
        Ok(u8::load(from)? != 0)
    }
}

impl Saved for Vec3 {
    fn save(&self, out: &mut dyn Write) -> io::Result<()> {
        <[f32; 3]>::from(*self).save(out)
    }

    fn load(from: &mut dyn Read) -> io::Result<Self> {
        Ok(<[f32; 3]>::load(from)?.into())
    }
}

impl<T: Saved> Saved for Box<T> {
    fn save(&self, out: &mut dyn Write) -> io::Result<()> {
        T::save(self, out)
    }

    fn load(from: &mut dyn Read) -> io::Result<Self> {
        Ok(Box::new(T::load(from)?))
    }
}

impl<T: Saved> Saved for Option<T> {
    fn save(&self, out: &mut dyn Write) -> io::Result<()> {
        self.is_some().save(out)?;
        self.iter().try_for_each(|x| x.save(out))
    }

    fn load(from: &mut dyn Read) -> io::Result<Self> {
        bool::load(from)?.then(|| T::load(from)).transpose()
    }
}

impl<A: Saved, B: Saved> Saved for (A, B) {
    fn save(&self, out: &mut dyn Write) -> io::Result<()> {
        self.0.save(out)?;
        self.1.save(out)
    }

    fn load(from: &mut dyn Read) -> io::Result<Self> {
        Ok((A::load(from)?, B::load(from)?))
    }
}

impl<T: Saved> Saved for Vec<T> {
    fn save(&self, out: &mut dyn Write) -> io::Result<()> {
        (self.len() as u64).save(out)?;
        self.iter().try_for_each(|x| x.save(out))
    }

    fn load(from: &mut dyn Read) -> io::Result<Self> {
        // Grows as it reads: a false length ends at the end of what is there.
        (0..u64::load(from)?).map(|_| T::load(from)).collect()
    }
}

impl<T: Saved, const N: usize> Saved for [T; N] {
    fn save(&self, out: &mut dyn Write) -> io::Result<()> {
        self.iter().try_for_each(|x| x.save(out))
    }

    fn load(from: &mut dyn Read) -> io::Result<Self> {
        let list: Vec<T> = (0..N).map(|_| T::load(from)).collect::<io::Result<_>>()?;
        list.try_into().map_err(|_| io::ErrorKind::InvalidData.into())
    }
}

/// [`Saved`] of a structure by its fields.
macro_rules! saved {
    ($T:ident $(<$P:ident>)? { $($field:ident),* $(,)? }) => {
        impl$(<$P: $crate::saved::Saved>)? $crate::saved::Saved for $T$(<$P>)? {
            fn save(&self, out: &mut dyn std::io::Write) -> std::io::Result<()> {
                $($crate::saved::Saved::save(&self.$field, out)?;)*
                Ok(())
            }

            fn load(from: &mut dyn std::io::Read) -> std::io::Result<Self> {
                Ok($T { $($field: $crate::saved::Saved::load(from)?),* })
            }
        }
    };
}
pub(crate) use saved;

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, PartialEq)]
    struct Pair<T> {
        number: T,
        list: Vec<Option<[f32; 3]>>,
    }
    saved!(Pair<T> { number, list });

    #[test]
    fn what_is_saved_comes_back_and_what_is_cut_short_does_not() {
        let pair = Pair { number: 7u64, list: vec![None, Some([0.1, -0.0, f32::INFINITY])] };
        let mut bytes = Vec::new();
        pair.save(&mut bytes).unwrap();
        assert_eq!(Pair::<u64>::load(&mut &bytes[..]).unwrap(), pair);
        for n in 0..bytes.len() {
            assert!(Pair::<u64>::load(&mut &bytes[..n]).is_err(), "{n}");
        }
    }
}
