# What R says of the matrices of tests/common/analysis/reference; run by reference_statistics.py.
suppressPackageStartupMessages(library(vegan))
folder <- commandArgs(trailingOnly = TRUE)[1]
read <- function(name) {
  as.matrix(read.csv(file.path(folder, name), row.names = 1, check.names = FALSE))
}
a <- read("distances_a.csv")
b <- read("distances_b.csv")
c <- read("distances_c.csv")
labels <- read.csv(file.path(folder, "labels.csv"))
permutations <- 99999
out <- file(file.path(folder, "r.txt"), "w")
say <- function(name, values) {
  cat(name, format(as.numeric(values), digits = 17, trim = TRUE), "\n", file = out)
}
cat("# R", paste(R.version$major, R.version$minor, sep = "."), "vegan",
    as.character(packageVersion("vegan")), "\n", file = out)
set.seed(1)
for (method in c("pearson", "spearman")) {
  test <- mantel(as.dist(a), as.dist(b), method = method, permutations = permutations)
  say(paste0("mantel_", method), c(test$statistic, test$signif))
  test <- mantel.partial(as.dist(a), as.dist(b), as.dist(c), method = method,
                         permutations = permutations)
  say(paste0("partial_", method), c(test$statistic, test$signif))
}
for (column in c("group", "person")) {
  test <- adonis2(as.dist(a) ~ labels[[column]], permutations = permutations)
  say(paste0("permanova_", column),
      c(test$SumOfSqs, test$R2[1], test$F[1], test[["Pr(>F)"]][1], test$Df))
}
methods <- list(average = "average", complete = "complete", single = "single", ward = "ward.D2")
for (name in names(methods)) {
  tree <- hclust(as.dist(a), methods[[name]])
  say(paste0(name, "_height"), tree$height)
  say(paste0(name, "_merge"), t(tree$merge))
  say(paste0(name, "_order"), tree$order)
  say(paste0(name, "_three_clusters"), cutree(tree, 3))
}
scaled <- cmdscale(as.dist(a), k = 4, eig = TRUE)
say("eigenvalues", scaled$eig)
for (axis in 1:4) say(paste0("axis_", axis), scaled$points[, axis])
say("goodness", scaled$GOF)
close(out)
