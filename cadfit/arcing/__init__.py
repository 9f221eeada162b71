"""Curves to lines and arcs: the fewest found (`chain`), certified (`within`), as one immutable result (`result`)."""
