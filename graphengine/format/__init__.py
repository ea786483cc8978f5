"""Reads YAML files as checked specs: documents with places, findings and errors, access to files."""
