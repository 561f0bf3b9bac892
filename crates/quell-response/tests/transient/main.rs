//! Transients against closed forms, published figures and each other.

mod events;
mod exponentials;
mod oscillators;
mod pulses;
mod strut;
mod touch_down;
