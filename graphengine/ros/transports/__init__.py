"""The transports that carry messages, and the choice between them."""
