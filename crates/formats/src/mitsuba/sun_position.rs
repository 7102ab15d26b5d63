//! Where the sun stands (Blanco-Muriel, Alarcón-Padilla, López-Moratalla, Lara-Coira, "Computing
//! the Solar Vector", Solar Energy 70(5), 2001; good to half a minute of arc from 1999 to 2015).
//!
//! ```text
//! n = JD - 2451545                                   days since noon of 1 January 2000, UT   (1)
//! Ω = 2.1429 - 0.0010394594 n,  L = 4.8950630 + 0.017202791698 n,  g = 6.2400600 + 0.0172019699 n
//! l = L + 0.03341607 sin g + 0.00034894 sin 2g - 0.0001134 - 0.0000203 sin Ω                 (2)
//! ε = 0.4090928 - 6.2140e-9 n + 0.0000396 cos Ω                                              (3)
//! tan α = cos ε sin l / cos l,  sin δ = sin ε sin l                                          (4)
//! ω = 15° (6.6974243242 + 0.0657098283 n + h) + longitude - α                                (5)
//! cos θ = cos φ cos ω cos δ + sin δ sin φ,  tan γ = -sin ω / (tan δ cos φ - sin φ cos ω)     (6)
//! θ' = θ + (6371.01 / 149597890) sin θ                                                       (7)
//! ```

use std::f64::consts::PI;

/// A place on the earth, and the local time there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moment {
    /// Degrees, north positive.
    pub latitude: f64,
    /// Degrees, east positive.
    pub longitude: f64,
    /// Hours ahead of universal time.
    pub timezone: f64,
    pub year: i64,
    pub month: i64,
    pub day: i64,
    /// Hours since midnight.
    pub hour: f64,
}

impl Moment {
    /// (1): the Julian date by Fliegel and Van Flandern's formula (1968), whose divisions round
    /// toward zero.
    pub fn days(&self, universal: f64) -> f64 {
        let (y, m, d) = (self.year, self.month, self.day);
        let a = (m - 14) / 12;
        let number = (1461 * (y + 4800 + a)) / 4 + (367 * (m - 2 - 12 * a)) / 12
            - (3 * ((y + 4900 + a) / 100)) / 4
            + d
            - 32075;
        number as f64 - 0.5 + universal / 24.0 - 2_451_545.0
    }

    /// Angle from the zenith and azimuth of the sun, from north by east, radians.
    pub fn sun(&self) -> (f64, f64) {
        let universal = self.hour - self.timezone;
        let n = self.days(universal);
        let node = 2.1429 - 0.0010394594 * n;
        let anomaly = 6.2400600 + 0.0172019699 * n;
        let l = 4.8950630
            + 0.017202791698 * n
            + 0.03341607 * anomaly.sin()
            + 0.00034894 * (2.0 * anomaly).sin()
            - 0.0001134
            - 0.0000203 * node.sin(); // (2)
        let obliquity = 0.4090928 - 6.2140e-9 * n + 0.0000396 * node.cos(); // (3)
        let ascension = (obliquity.cos() * l.sin()).atan2(l.cos()); // (4)
        let declination = (obliquity.sin() * l.sin()).asin();
        let sidereal = 6.6974243242 + 0.0657098283 * n + universal;
        let hour_angle = (15.0 * sidereal + self.longitude).to_radians() - ascension; // (5)
        let latitude = self.latitude.to_radians();
        let cos = latitude.cos() * hour_angle.cos() * declination.cos()
            + declination.sin() * latitude.sin(); // (6)
        let zenith = cos.clamp(-1.0, 1.0).acos();
        let azimuth = (-hour_angle.sin())
            .atan2(declination.tan() * latitude.cos() - latitude.sin() * hour_angle.cos());
        let parallax = 6371.01 / 149_597_890.0 * zenith.sin(); // (7)
        (zenith + parallax, azimuth.rem_euclid(2.0 * PI))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn degrees(m: Moment) -> [f64; 2] {
        let (zenith, azimuth) = m.sun();
        [90.0 - zenith.to_degrees(), azimuth.to_degrees()]
    }

    /// Elevation (without refraction) and azimuth by the other algorithm of the field: NREL's, as
    /// worked through in its report (Reda and Andreas 2004, table A5.1), to half a minute of arc.
    #[test]
    fn the_worked_example_of_another_algorithm() {
        let golden = Moment {
            latitude: 39.742476,
            longitude: -105.1786,
            timezone: -7.0,
            year: 2003,
            month: 10,
            day: 17,
            hour: 12.0 + 30.0 / 60.0 + 30.0 / 3600.0,
        };
        let [elevation, azimuth] = degrees(golden);
        // Topocentric elevation 39.872046°, azimuth 194.340241°.
        assert!((elevation - 39.872046).abs() < 0.5 / 60.0, "{elevation}");
        assert!((azimuth - 194.340241).abs() < 0.5 / 60.0, "{azimuth}");
    }

    #[test]
    fn the_sun_rises_in_the_east() {
        let tokyo = Moment {
            latitude: 35.6894,
            longitude: 139.6917,
            timezone: 9.0,
            year: 2010,
            month: 7,
            day: 10,
            hour: 6.0,
        };
        let [elevation, azimuth] = degrees(tokyo);
        assert!(elevation > 10.0 && elevation < 20.0 && azimuth > 60.0 && azimuth < 80.0);
        // At noon, 90° - latitude + declination, and within half an hour of due south.
        let [elevation, azimuth] = degrees(Moment { hour: 11.77, ..tokyo });
        assert!((elevation - (90.0 - 35.69 + 22.2)).abs() < 0.3, "{elevation}");
        assert!((azimuth - 180.0).abs() < 4.0, "{azimuth}");
    }
}
