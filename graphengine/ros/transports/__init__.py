"""The transports that carry messages, and which of them a session takes."""
