//! What the matrices give: illuminance, pictures, glare, each with its error.

pub mod annual;
pub mod glare;
pub mod illuminance;
pub mod pictures;
pub mod sensors;
pub mod suns;
pub mod uncertainty;
pub mod views;
