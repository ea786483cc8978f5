"""Scripts that build graphs: `reading` them, by evaluating literals (`plain`), or in a confined `process`."""
