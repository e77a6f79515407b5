#include "client/client_main.h"

int main(int argc, char** argv) {
  return cohort::ClientMain(argc, argv);
}
