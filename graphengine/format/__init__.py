"""YAML files to checked specs: documents with spans, findings and errors, access to files."""
