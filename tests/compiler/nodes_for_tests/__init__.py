"""Small nodes, one for each shape and rule; what they do they write to a journal, in the order they do it."""
