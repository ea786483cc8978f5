"""Processes that read what strangers wrote, confined by the kernel."""
