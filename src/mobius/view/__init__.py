"""What a run looked like: report and video."""
