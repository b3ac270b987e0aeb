//! Surfaces as sound and light see them.

use std::f64::consts::FRAC_PI_2;

/// A surface as a sonar and a laser see it.
///
/// Sound of 50 kHz has a wavelength of 7 mm. A surface that is smooth at that scale is a mirror:
/// beyond a critical angle of incidence the echo goes elsewhere. A rough one scatters.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The name in missions, such as `plaster`.
    pub name: &'static str,
    /// Incidence, from the surface's normal, beyond which the mirror-like echo misses the
    /// sensor, radians, from 0 to π/2.
    pub specular_from_rad: f64,
    /// Strength of the echo up to that angle, from 0 to 1.
    pub reflectivity_ratio: f64,
    /// Strength of what is scattered back beyond that angle, before the cosine of the incidence,
    /// from 0 to 1. Zero: nothing comes back.
    pub diffuse_ratio: f64,
    /// What it does to a laser's beam.
    pub light: Light,
}

/// What a surface does to the near-infrared beam of a laser range finder. The three parts add up to
/// at most 1; the rest is swallowed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Part that is scattered to all sides (remission), from 0 to 1: what a range finder lives on.
    pub diffuse_ratio: f64,
    /// Part that goes on as from a mirror, from 0 to 1.
    pub mirrored_ratio: f64,
    /// Part that goes straight through, from 0 to 1.
    pub transmitted_ratio: f64,
}

impl Light {
    /// A surface that scatters only.
    const fn matt(diffuse_ratio: f64) -> Self {
        Self { diffuse_ratio, mirrored_ratio: 0.0, transmitted_ratio: 0.0 }
    }
}

/// Tag of walls whose material nobody states: plaster.
pub const WALL_TAG: u32 = 0;
/// Tag of robots: a painted body with wheels and edges scatters like wood rather than like sheet
/// metal.
pub const ROBOT_TAG: u32 = 1;
/// Tag of people.
pub const PERSON_TAG: u32 = 6;

/// The surfaces there are, in the order of their tags; tag 0 is a plastered wall.
///
/// The critical angles are our choice within the usual experience that painted walls vanish
/// beyond some 25 to 30 degrees, glass and steel earlier, and cloth hardly ever. For light, clear
/// glass reflects about 4 % at each of its two faces (Fresnel, refractive index 1.5); the
/// remissions are our choice within what makers of range finders quote: white plaster 80 %, cardboard
/// and wood around 50 to 60 %, dark cloth 10 to 40 %.
static MATERIALS: [Material; 8] = [
    Material {
        name: "plaster",
        specular_from_rad: 0.52,
        reflectivity_ratio: 1.0,
        diffuse_ratio: 0.12,
        light: Light::matt(0.8),
    },
    Material {
        name: "wood",
        specular_from_rad: 0.61,
        reflectivity_ratio: 0.9,
        diffuse_ratio: 0.18,
        light: Light::matt(0.5),
    },
    Material {
        name: "glass",
        specular_from_rad: 0.26,
        reflectivity_ratio: 1.0,
        diffuse_ratio: 0.0,
        light: Light { diffuse_ratio: 0.0, mirrored_ratio: 0.08, transmitted_ratio: 0.85 },
    },
    Material {
        name: "fabric",
        specular_from_rad: 1.22,
        reflectivity_ratio: 0.35,
        diffuse_ratio: 0.20,
        light: Light::matt(0.4),
    },
    Material {
        name: "metal",
        specular_from_rad: 0.30,
        reflectivity_ratio: 1.0,
        diffuse_ratio: 0.0,
        light: Light { diffuse_ratio: 0.3, mirrored_ratio: 0.5, transmitted_ratio: 0.0 },
    },
    Material {
        name: "cardboard",
        specular_from_rad: 0.70,
        reflectivity_ratio: 0.8,
        diffuse_ratio: 0.20,
        light: Light::matt(0.6),
    },
    Material {
        name: "person",
        specular_from_rad: FRAC_PI_2,
        reflectivity_ratio: 0.45,
        diffuse_ratio: 0.25,
        light: Light::matt(0.3),
    },
    Material {
        name: "mirror",
        specular_from_rad: 0.26,
        reflectivity_ratio: 1.0,
        diffuse_ratio: 0.0,
        light: Light { diffuse_ratio: 0.005, mirrored_ratio: 0.9, transmitted_ratio: 0.0 },
    },
];

/// The built-in surfaces; a tag of a scene is an index into this list.
pub fn materials() -> &'static [Material] {
    &MATERIALS
}

/// Index and surface of the built-in material `name`, or `None`.
pub fn material_by_name(name: &str) -> Option<(u32, &'static Material)> {
    (0..).zip(&MATERIALS).find(|(_, material)| material.name == name)
}

/// A list with the indices of [`materials`] whose every entry behaves like `like`; for
/// experiments that vary one property of all surfaces.
pub fn materials_like(like: &Material) -> Vec<Material> {
    MATERIALS.iter().map(|m| Material { name: m.name, ..like.clone() }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_give_their_index() {
        for (tag, material) in (0..).zip(materials()) {
            assert_eq!(material_by_name(material.name), Some((tag, material)));
        }
        assert_eq!(material_by_name("snow"), None);
    }

    #[test]
    fn constant_tags_mean_what_they_say() {
        let tag = |name| material_by_name(name).unwrap().0;
        assert_eq!([tag("plaster"), tag("wood"), tag("person")], [WALL_TAG, ROBOT_TAG, PERSON_TAG]);
    }

    #[test]
    fn smooth_things_vanish_earlier_than_rough_ones() {
        let critical = |name| material_by_name(name).unwrap().1.specular_from_rad;
        let order = ["glass", "metal", "plaster", "wood", "cardboard", "fabric", "person"];
        for pair in order.windows(2) {
            assert!(critical(pair[0]) < critical(pair[1]), "{pair:?}");
        }
    }

    #[test]
    fn every_number_is_in_its_range() {
        for m in materials() {
            assert!((0.0..=FRAC_PI_2).contains(&m.specular_from_rad), "{m:?}");
            assert!((0.0..=1.0).contains(&m.reflectivity_ratio), "{m:?}");
            assert!((0.0..=1.0).contains(&m.diffuse_ratio), "{m:?}");
            let Light { diffuse_ratio, mirrored_ratio, transmitted_ratio } = m.light;
            let parts = [diffuse_ratio, mirrored_ratio, transmitted_ratio];
            assert!(parts.iter().all(|part| (0.0..=1.0).contains(part)), "{m:?}");
            assert!(parts.iter().sum::<f64>() <= 1.0, "{m:?}");
        }
    }
}
