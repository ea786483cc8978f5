"""Processes that read untrusted files, confined by the kernel."""
