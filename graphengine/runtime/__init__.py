"""What a session is made of: the tick and its pace, what comes in from outside, and what the graphs of a run share."""
