"""A run as one HTML file, which a browser opens from disk: its scripts, style and data are inside.

`api.recording_page.sample_replay` replays a recording and returns its samples; a running session is sampled by calling
`trace.SceneTrace.sample` after each tick. `html_file.write_html` writes the samples, with plots, marks and a log.
"""
