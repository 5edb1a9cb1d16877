//! Skies: Perez all-weather luminance on Reinhart patches, one column per hour.
