"""What a gear pair looks like on paper: tables, figures, reports and files for other programs."""
