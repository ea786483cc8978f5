"""Reads MuJoCo's own models; `mjcf_trial` compiles an untrusted model in a confined process first."""
