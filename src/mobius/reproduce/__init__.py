"""The paper's tables and figures, computed: ours beside the printed value."""
