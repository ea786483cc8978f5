"""Drawings of graphs: what is on them (`scheme`), where it stands (`arrange`), and how it is written (`svg`, `page`)."""
