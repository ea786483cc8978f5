"""Control of a running session from other threads and programs: the socket of `graphrun ctl`, and simulation_interfaces."""
