"""Where the motions come from: their design in few numbers, a rehearsal, and the search."""
