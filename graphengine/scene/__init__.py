"""The one room that composes physics, network and graphs: from files to a session."""
