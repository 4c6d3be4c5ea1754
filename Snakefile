# The workflow is in workflow/; this file lets its command work from the root of the repository.
include: "workflow/Snakefile"
