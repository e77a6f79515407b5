# Results of two jobs in base R: matrices, their heat map's numbers, and the Mantel test.
#   Rscript mantel.R results_a results_b [permutations]
# Prints what `cohort mantel results_a results_b` prints: r, and p within the chance of permutations.
arguments <- commandArgs(trailingOnly = TRUE)
if (length(arguments) < 2) stop("usage: Rscript mantel.R RESULTS_A RESULTS_B [PERMUTATIONS]")
permutations <- if (length(arguments) > 2) as.integer(arguments[3]) else 9999L

read_matrix <- function(folder) {
  table <- read.csv(file.path(folder, "matrix.csv"), row.names = 1, check.names = FALSE)
  as.matrix(table)
}
a <- read_matrix(arguments[1])
b <- read_matrix(arguments[2])
# The same meshes in the same order.
stopifnot(setequal(rownames(a), rownames(b)))
b <- b[rownames(a), rownames(a)]

lower <- lower.tri(a)
r <- cor(a[lower], b[lower])
set.seed(1)
as_extreme <- sum(replicate(permutations, {
  order <- sample(nrow(a))
  cor(a[order, order][lower], b[lower]) >= r - 1.5e-8
}))
cat(sprintf("meshes %d\nr %.15g\np %.6g\n", nrow(a), r, (1 + as_extreme) / (1 + permutations)))
