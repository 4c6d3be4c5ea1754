"""What the paper says, beside what came out here: statements, tables and the page that shows them."""
