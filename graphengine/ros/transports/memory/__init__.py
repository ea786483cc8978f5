"""A transport that never leaves the process."""
