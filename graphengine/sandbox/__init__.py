"""Runs code and native readers on untrusted files in processes that the kernel confines."""
