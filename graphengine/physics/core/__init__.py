"""Steps and resets a model with the laws of `dynamics`; the base of handles, and the bodies that graphs hold at a pose."""
