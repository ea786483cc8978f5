"""From files of YAML to checked specs: documents with places, findings and errors, access to files."""
